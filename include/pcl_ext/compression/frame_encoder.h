#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/compression_status.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief What a frame may carry of a cloud's header. */
struct FrameStamp {
  std::uint64_t stamp = 0; ///< time of the frame, microseconds in PCL
  std::string frame_id;    ///< name of the coordinate frame, 1024 bytes at most
};

/** \brief Turns the voxel frames of one stream into bytes. Knows no points and no PCL.
 */
class PCL_EXT_EXPORT FrameEncoder {
public:
  /** \brief An encoder at the start of a stream.
   * \param[in] format bitstream to write
   * \param[in] i_frame_rate frames from one I-frame to the next; 0 counts as 1
   * \param[in] effort time against size; Version1 only
   */
  FrameEncoder(StreamFormat format,
               unsigned int i_frame_rate,
               Effort effort = Effort::Balanced);
  ~FrameEncoder();
  FrameEncoder(FrameEncoder&&) noexcept;
  FrameEncoder&
  operator=(FrameEncoder&&) noexcept;

  /** \brief True if the next frame will be an I-frame whatever it holds. */
  bool
  isIFrameDue() const;

  /** \brief Makes the next frame an I-frame. */
  void
  requestIFrame();

  /** \brief Encodes the next frame of the stream; a frame may be empty. It has 2^24 voxels
   * at most; a decoder with the default limits takes 2^20.
   * \param[in] frame the voxels
   * \param[in] stamp what to carry of the cloud's header, if anything; Version1 only
   * \param[out] bytes the whole frame; replaces what was there
   * \return Ok; InvalidInput, after which the stream goes on unharmed; OutOfMemory, after
   * which the next frame is an I-frame. There are no bytes then
   */
  CompressionStatus
  encode(const VoxelFrame& frame,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes);

  /** \brief Figures of the last frame. */
  const CodedFrameStatistics&
  statistics() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace io
} // namespace pcl_ext

#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "context_coder.h"
#include "payload_context.h"
#include "voxel_block.h"
#include "voxel_history.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Records that the history may hold when a P-frame comes, where no frame has more
 * than some number of voxels: encoders start again at an I-frame, decoders refuse. */
constexpr std::size_t
maxRecords(std::size_t voxels)
{
  return 16 * voxels + 65536;
}

/** \brief Bytes of a payload by what they tell. */
struct PayloadSizes {
  std::size_t occupancy = 0;
  std::size_t intensity = 0;
};

/** \brief Turns the voxels of one stream's frames into payloads and back, with the coder
 * of an effort; keeps the stream's history. One instance serves one direction. */
class PayloadCoder {
public:
  /** \brief Appends the payload of the next frame of the stream, and learns it.
   * \param[in] frame consistent; it may be without voxels
   * \param[in] is_i_frame forget what was before
   * \param[in] effort which coder; that of the I-frame on P-frames
   * \param[in,out] payload where to append
   */
  PayloadSizes
  encode(const VoxelFrame& frame,
         bool is_i_frame,
         Effort effort,
         std::vector<std::uint8_t>& payload);

  /** \brief Reads back what encode appended, and learns it. A failure leaves what was
   * learnt as it was.
   * \param[in] begin first byte
   * \param[in] end end of the payload, all of which must be used
   * \param[in] voxel_count number of voxels of the frame
   * \param[in] is_i_frame as for encode
   * \param[in] effort as for encode
   * \param[in,out] frame its voxels are filled; the rest is given
   * \param[out] sizes as encode returns
   * \return false if the bytes are no payload of that many voxels
   */
  bool
  decode(const std::uint8_t* begin,
         const std::uint8_t* end,
         std::size_t voxel_count,
         bool is_i_frame,
         Effort effort,
         VoxelFrame& frame,
         PayloadSizes& sizes);

  /** \brief How much of a frame the history knows.
   * \param[in] frame the voxels
   * \return number of its voxels that have a record
   */
  std::size_t
  knownVoxels(const VoxelFrame& frame);

  /** \brief Number of voxels that have a record. */
  std::size_t
  recordCount() const
  {
    return history_.records().count;
  }

private:
  PayloadContext
  contextOf(const VoxelFrame& frame, bool is_i_frame, Effort effort);

  ContextCoder&
  contextCoder(Effort effort);

  void
  learn(const VoxelFrame& frame, bool is_i_frame, Effort effort);

  VoxelHistory history_;
  VoxelHistory empty_history_; // of I-frames, as a failure must not clear the other
  // The coder of the stream's effort, made when it is first asked for.
  std::unique_ptr<ContextCoder> balanced_;
  std::unique_ptr<ContextCoder> small_;
  // Of the current frame; members so that their memory is reused.
  BlockList blocks_;
  CodedIntensities intensities_;
  DepthObservations depths_;
};

} // namespace io
} // namespace pcl_ext

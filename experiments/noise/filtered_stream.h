/** \file
 * \brief A stream with one filter: what it shows, its bytes, and its times.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "measuring/samples.h"
#include "temporal_judge.h"

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief Bytes of a stream with one effort and one rate of I-frames. */
class CodedBytes {
public:
  CodedBytes(io::Effort effort, unsigned int i_frame_rate);

  /** \brief Encodes the next frame.
   * \return its bytes; valid until the next call
   * \throws std::runtime_error if it cannot be encoded
   */
  const std::vector<std::uint8_t>&
  encode(const io::VoxelFrame& frame);

  /** \brief Bytes of the frame that was encoded last. */
  std::size_t
  lastSize() const
  {
    return bytes_.size();
  }

  std::string name; ///< effort and rate
  measuring::Samples all;
  measuring::Samples i_frames;
  measuring::Samples p_frames;

private:
  io::FrameEncoder encoder_;
  std::vector<std::uint8_t> bytes_;
};

/** \brief VoxelOutlierRemoval, TemporalVoxelFilter, both in this order, or none. */
class FilterChain {
public:
  /** \brief Filters at the start of a stream.
   * \param[in] removes_outliers at log-odds 0
   * \param[in] is_temporal with the usual strength
   * \param[in] law of the intensities
   */
  FilterChain(bool removes_outliers, bool is_temporal, Law law);

  /** \brief Filters the next frame.
   * \throws std::runtime_error if a filter refuses it
   */
  void
  filter(io::VoxelFrame& frame, const Eigen::Vector3d& sensor_position);

private:
  std::optional<VoxelOutlierRemoval> outliers_;
  std::optional<TemporalVoxelFilter> temporal_;
};

/** \brief A stream with one filter. */
class FilteredStream {
public:
  /** \brief For a stream.
   * \param[in] name of the filter
   * \param[in] chain at the start of a stream; makes another one with each call
   * \param[in] first_judged see ShownJudge
   */
  FilteredStream(std::string name,
                 const std::function<FilterChain()>& chain,
                 std::int64_t first_judged);

  /** \brief Filters, encodes, decodes and judges the next frame.
   * \param[in] truth to which it was added last
   * \param[in] measured the frame
   * \param[in] sensor_position in it
   */
  void
  add(const SurfaceHistory& truth,
      const io::VoxelFrame& measured,
      const Eigen::Vector3d& sensor_position);

  const io::VoxelFrame&
  shown() const
  {
    return shown_;
  }

  std::string name;
  ShownJudge judge;
  measuring::Samples voxels;
  measuring::Samples filter_ms;
  measuring::Samples decode_ms; ///< of the last of coded
  std::vector<CodedBytes> coded;

private:
  /** \brief Instances that do the same in turns; the shortest time of a frame counts. */
  static constexpr std::size_t repetitions = 3;

  std::vector<FilterChain> chains_;
  std::vector<io::FrameDecoder> decoders_;
  io::VoxelFrame shown_;
};

} // namespace noise
} // namespace pcl_ext

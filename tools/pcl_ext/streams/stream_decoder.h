// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/decoder_limits.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/recording/recording_reader.h>

#include "codec/memory_share.h"
#include "console/console.h"
#include "inputs/stream_metadata.h"
#include "options/decoding_options.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace pcl_ext::tools {

/** \brief Why a frame was not decoded, without the number that the encoder gave it,
 * which is not that of the frame in its recording. */
std::string
reasonOf(const io::CompressionStatus& status);

/** \brief Position of a stream's sensor, world coordinates, metres, if it is known. */
std::optional<std::array<double, 3>>
positionOf(const StreamMetadata& metadata);

/** \brief How outliers of a stream are removed, by the options and what is known of it.
 * \param[in] first frame of the stream
 */
VoxelOutlierRemovalSettings
outlierRemovalOf(const DecodingOptions& options,
                 const StreamMetadata& metadata,
                 const io::VoxelFrame& first);

/** \brief Why the unit of the options cannot judge the voxels of a stream; empty if it can,
 * or if that is not known.
 * \param[in] has_point_counts whether its voxels have, or may have, numbers of points
 */
std::string
unitFaultOf(const DecodingOptions& options,
            const StreamMetadata& metadata,
            bool has_point_counts);

/** \brief Remarks that frames were decoded again to keep --memory-limit, if any were. */
void
remarkOnMemory(const io::DecoderLimits& limits, Console& console);

/** \brief Decodes the frames of a stream in their order, and filters them. */
class StreamDecoder {
public:
  /** \param[in] reader must outlive this
   * \param[in] stream index in its streams
   * \param[in] name of the stream, for messages
   * \param[out] voxels of the last frame; decoders in turn may have the same
   */
  StreamDecoder(recording::RecordingReader& reader,
                std::size_t stream,
                const std::string& name,
                const DecodingOptions& options,
                io::VoxelFrame& voxels);

  /** \brief Decodes the next frame.
   * \return with a warning if points have no voxel, which filters need
   * \throws UsageError if the unit of the options is not for the law of the recording
   */
  io::CompressionStatus
  decode(const recording::RecordedFrame& frame);

  /** \brief What is left of the last frame, with points only where it has them and
   * nothing was filtered. */
  const io::VoxelFrame&
  voxels() const
  {
    return voxels_;
  }

  /** \brief How many voxels the last frame had before it was filtered. */
  std::size_t
  decodedVoxels() const
  {
    return decoded_voxels_;
  }

  /** \brief What outliers are judged by, once some were. */
  std::optional<DensityUnit>
  judgedBy() const;

  /** \brief Whether some frame could not be filtered as was asked for, or all voxels
   * were outliers, which remark() tells. */
  bool
  isFailure() const
  {
    return outliers_stay_ || lacks_intensities_ || isAllRemoved();
  }

  /** \brief Why frames were not filtered, or what is wrong with the outliers; empty if
   * there is nothing to say. */
  std::string
  remark() const;

private:
  /** \brief The filter of the stream, whose history is dropped where the memory is needed
   * elsewhere. */
  struct Removal {
    Removal(const VoxelOutlierRemovalSettings& removal_settings,
            std::shared_ptr<io::MemoryBudget> budget)
    : settings(removal_settings), share(std::move(budget), [this] { filter.reset(); })
    {}

    VoxelOutlierRemovalSettings settings;
    std::optional<VoxelOutlierRemoval> filter; // made when it is needed
    io::MemoryShare share;
  };

  bool
  isAllRemoved() const
  {
    return judged_ > 0 && removed_ == judged_;
  }

  /** \brief Makes the filter for a stream that begins with voxels_.
   * \throws UsageError if the unit is not for the law of the recording
   */
  void
  makeRemoval();

  /** \brief Removes outliers from voxels_. */
  void
  removeOutliers(std::size_t number);

  recording::RecordedStreamDecoder decoder_;
  std::string name_;
  DecodingOptions options_;
  StreamMetadata metadata_;
  std::unique_ptr<Removal> removal_;
  std::optional<DensityUnit> unit_; // by which outliers were judged last
  io::VoxelFrame& voxels_;
  std::size_t decoded_voxels_ = 0;
  bool lacks_intensities_ = false;   // some frame, which --min-intensity needs
  bool has_intensity_field_ = false; // some frame of these
  bool outliers_stay_ = false;       // in some frame
  bool is_automatic_;                // the unit was not named
  bool has_intensities_ = true;
  std::size_t judged_ = 0;  // voxels
  std::size_t removed_ = 0; // of these
  std::string remark_;
};

} // namespace pcl_ext::tools

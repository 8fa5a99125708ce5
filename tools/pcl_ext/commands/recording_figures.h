// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_reader.h>

#include "console/console.h"
#include "inputs/recording_input.h"
#include "streams/loss_count.h"
#include "streams/point_orders.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief What the headers of a stream's frames tell. */
struct StreamFigures {
  std::string name;
  std::size_t frames = 0;
  std::size_t i_frames = 0;
  bool has_times = false;
  recording::Time first_time{0};
  recording::Time last_time{0};
  std::uint64_t bytes = 0;
  /** \brief Of the frames whose headers tell their voxels: in the published layout
   * I-frames alone. */
  std::size_t frames_with_voxels = 0;
  std::uint64_t voxels = 0;
  std::size_t frames_in_order = 0; ///< scans, which have points and no voxels
  std::uint64_t points_in_order = 0;
  double resolution = 0.0; ///< metres, of the first I-frame; 0: there is none
  bool has_one_resolution = true;
  io::StreamFormat format = io::StreamFormat::Version1;
  io::Effort effort = io::Effort::Fast; ///< of the first I-frame, as the format
  bool has_points = false;              ///< in any I-frame
  /** \brief Of the I-frames with points: the most bits, and all fields. */
  unsigned int intensity_bits = 0;
  unsigned int colour_bits = 0;
  bool has_point_counts = false;
  std::vector<io::FieldDescription> fields;
  PointOrders orders; ///< of scans
  io::ImageSize scan; ///< size of the first one
  bool is_organised = false;
  bool is_row_by_row = false;
  std::string frame_id;
  std::size_t missing = 0;    ///< by the numbers of the frames
  std::size_t unreadable = 0; ///< in the recording, but damaged
  LossCount losses;

  /** \brief Whether an I-frame tells how the stream is coded. */
  bool
  hasIFrame() const
  {
    return resolution > 0.0;
  }

  double
  duration() const
  {
    return std::chrono::duration<double>(last_time - first_time).count();
  }

  /** \brief Frames a second; 0: unknown. */
  double
  rate() const
  {
    return frames > 1 && duration() > 0.0 ? static_cast<double>(frames - 1) / duration()
                                          : 0.0;
  }

  /** \brief Whether all frames tell how many voxels or points they have. */
  bool
  tellsSizes() const
  {
    return frames_with_voxels + frames_in_order >= frames - unreadable;
  }

  /** \brief Mean of the frames with voxels; 0: there are none, or not all tell. */
  double
  meanVoxels() const
  {
    return frames_with_voxels == 0 || !tellsSizes()
               ? 0.0
               : static_cast<double>(voxels) / static_cast<double>(frames_with_voxels);
  }

  double
  meanBytes() const
  {
    const std::size_t read = frames - unreadable;
    return read == 0 ? 0.0 : static_cast<double>(bytes) / static_cast<double>(read);
  }

  /** \brief Mean of the scans. */
  double
  meanPointsInOrder() const
  {
    return frames_in_order == 0 ? 0.0
                                : static_cast<double>(points_in_order) /
                                      static_cast<double>(frames_in_order);
  }

  /** \brief Bytes per voxel, or point of a scan; 0: unknown, as not all frames tell how
   * many they have. */
  double
  bytesOfEach() const
  {
    const std::uint64_t all = voxels + points_in_order;
    return all == 0 || !tellsSizes()
               ? 0.0
               : static_cast<double>(bytes) / static_cast<double>(all);
  }
};

/** \brief Reads the headers of the chosen frames of a recording, without decoding
 * them. */
std::vector<StreamFigures>
figuresOf(RecordingInput& input, Console& console);

} // namespace pcl_ext::tools

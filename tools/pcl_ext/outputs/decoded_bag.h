// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/message_layout.h>

#include "inputs/recording_input.h"
#include "outputs/frame_output.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief A bag with the decoded clouds of a recording as sensor_msgs/msg/PointCloud2,
 * and with all other messages of a bag. Failures throw std::runtime_error. */
class DecodedBag {
public:
  /** \brief Opens the bag, with a topic for each stream that was chosen: its name
   * without /pcl_ext at its end.
   * \param[in] is_packed its points have no padding; else the layout of the messages that
   * a stream was made of, if it tells
   */
  DecodedBag(const Output& output, RecordingInput& input, bool is_packed);

  /** \brief Writes a decoded cloud.
   * \param[in,out] cloud gets the layout
   * \param[in] layout of its message; null: not known
   */
  void
  write(const RecordingInput::Item& item,
        const recording::RecordedFrame& frame,
        const io::MessageLayout* layout,
        pcl::PCLPointCloud2& cloud,
        RecordingInput& input);

  /** \brief Writes another message of the input as it is. */
  void
  passThrough(const RecordingInput::Item& item, RecordingInput& input);

  /** \brief Streams with messages that could not get their layout back, and why. */
  const std::map<std::size_t, std::string>&
  streamsWithoutLayout() const
  {
    return without_layout_;
  }

  /** \brief Copies metadata and attachments, and completes the bag, as
   * FrameOutput::finish(). */
  std::string
  finish(RecordingInput& input);

private:
  FrameOutput output_;
  std::vector<std::size_t> streams_; // channels of the streams
  bool is_packed_;
  std::map<std::size_t, std::string> without_layout_; // streams, and why
  std::vector<std::optional<std::size_t>> others_;    // of the channels of the input
  recording::McapMessage message_;
};

} // namespace pcl_ext::tools

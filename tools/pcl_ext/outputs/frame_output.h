// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_writer.h>

#include "outputs/output_path.h"
#include "recording/bag_reader.h"
#include "recording/mcap_writer.h"
#include "recording/point_cloud_messages.h"

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief An encoded frame to write. */
struct OutputFrame {
  recording::McapMessage message;     ///< its times and sequence number
  recording::PointCloudMessage cloud; ///< its header, sizes and fields
  std::vector<std::uint8_t> bytes;
};

/** \brief Writes encoded frames, and for bags other messages and all that is passed
 * through. Failures throw std::runtime_error. */
class FrameOutput {
public:
  /** \brief Opens an output.
   * \param[in] output its path: see OutputKind
   * \param[in] is_bag there may be other messages: frames get headers as those of the
   * transport for ROS 2
   * \param[in] profile of the bag that this one is made of; of "ros1" the output, which
   * has clouds or frames of ROS 2 besides, gets none
   */
  FrameOutput(const Output& output, bool is_bag, const std::string& profile);

  /** \brief True if other messages can be written. */
  bool
  isBag() const
  {
    return is_bag_;
  }

  /** \brief Adds a stream of frames. */
  std::size_t
  addStream(const recording::StreamToRecord& stream);

  /** \brief Adds a channel of a bag. */
  std::size_t
  addChannel(const recording::McapChannel& channel, recording::McapChunking chunking);

  /** \brief Writes the next frame of a stream. */
  void
  write(std::size_t stream, OutputFrame& frame);

  /** \brief Writes a message of addStream() as it is.
   * \param[in] is_i_frame whether its frame is one
   */
  void
  copy(const recording::McapMessage& message, bool is_i_frame);

  /** \brief Writes a message of addChannel(). */
  void
  write(const recording::McapMessage& message);

  /** \brief Write metadata and attachments of a bag. */
  void
  write(const recording::McapMetadata& metadata);
  void
  write(const recording::McapAttachment& attachment);

  /** \brief Writes all frames and messages at hand to the file. */
  void
  flush();

  /** \brief Removes what was written. */
  void
  discard();

  /** \brief Copies metadata and attachments of a bag. */
  void
  copyExtras(recording::BagReader& bag);

  /** \brief A sentence on what a file of frames cannot have; empty if there is nothing.
   * \param[in] messages of other topics
   */
  std::string
  describeLeftOut(std::size_t messages) const;

  /** \brief Completes the output and gives it its name. After an interruption an
   * earlier output keeps that, and this one stays unfinished.
   * \return what the interruption left, for the summary; empty if there was none
   */
  std::string
  finish();

private:
  void
  check(const recording::RecordingStatus& status);

  std::string path_;
  recording::ExistingFile existing_;
  bool is_of_bag_;
  bool is_bag_;
  bool has_other_times_ = false; // frames, that a file of frames cannot have
  recording::RecordingWriter recording_;
  recording::McapWriter bag_;
};

/** \brief What is left of an output that failed, after the reason; empty if nothing. */
std::string
describeUnfinished(const std::string& path);

/** \brief True if the program was interrupted, and an output would replace an earlier
 * one, which is complete. */
bool
keepsEarlierOutput(const std::string& path);

/** \brief What an interruption left, for the summary; empty if there was none.
 * \param[in] keeps_earlier see keepsEarlierOutput(), before the output was finished
 */
std::string
describeInterruption(const std::string& path, bool keeps_earlier);

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "console/console.h"
#include "inputs/recording_input.h"
#include "outputs/frame_output.h"
#include "stream/frame_chain.h"
#include "streams/frame_failures.h"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief The name of a stream as a topic: with a slash, which names of files lack. */
std::string
topicName(const std::string& prefix, const std::string& name);

/** \brief Copies encoded frames and messages of recordings into another one. The bytes
 * of frames and messages do not change. */
class CopiedStreams {
public:
  /** \brief Opens the output.
   * \param[in] is_bag there may be other messages
   * \param[in] bag whose profile the output gets; may be null
   */
  CopiedStreams(const Output& output,
                bool is_bag,
                const recording::BagReader* bag,
                Console& console);

  /** \brief Adds a recording, whose chosen streams get this prefix. A stream that is
   * there already goes on; so does another topic.
   * \param[in] input must outlive this
   */
  void
  addInput(RecordingInput& input, const std::string& prefix);

  /** \brief Copies what next() of an input found; what cannot be read, or not be decoded
   * without a frame that is missing, is reported. Other messages that several inputs have
   * are copied once, also latched ones that a part has at its beginning.
   * \param[in] input number of the addInput(); messages of all come in the order of
   * their times
   */
  void
  copy(std::size_t input, const RecordingInput::Item& item);

  /** \brief Copies metadata and attachments, completes the output and prints a summary.
   * \return the exit status
   */
  int
  finish();

private:
  struct Stream {
    std::string name;
    std::size_t number = 0; ///< in the output
    std::size_t input = 0;  ///< of the last frame
    io::FrameChain chain;   ///< of the frames of this input
  };

  struct Input {
    RecordingInput* recording;
    std::vector<std::optional<std::size_t>> streams;  ///< in streams_
    std::vector<std::optional<std::size_t>> channels; ///< in the output
  };

  /** \brief Another message of the time at hand, and how often inputs have it. */
  struct SeenMessage {
    recording::McapMessage message;
    std::size_t written = 0;
    std::vector<std::size_t> seen; ///< in each input
  };

  /** \brief Messages of a channel that parts repeat. */
  struct Latched {
    std::size_t most = 0; ///< see latchedMessages()
    std::vector<recording::McapMessage> copied;
  };

  std::size_t
  addStream(const Input& input, std::size_t stream, const std::string& name);

  /** \brief A channel of the output for other messages; the same for all inputs. */
  std::size_t
  numberOfChannel(const recording::McapChannel& channel);

  /** \brief Whether message_ is a latched one that was copied with an earlier time. */
  bool
  repeatsLatched();

  void
  copyMessage(std::size_t input);

  void
  copyFrame(std::size_t input, const RecordingInput::Item& item);

  void
  lose(const Input& input, const RecordingInput::Item& item, const std::string& reason);

  std::string path_;
  Console& console_;
  FrameFailures failures_;
  FrameOutput output_;
  std::vector<Input> inputs_;
  std::vector<Stream> streams_;
  std::vector<std::pair<recording::McapChannel, std::size_t>> channels_;
  recording::RecordedFrame frame_; // members so that their memory is reused
  recording::McapMessage message_;
  OutputFrame written_;
  std::size_t frames_ = 0;
  std::size_t leading_frames_ = 0;         // of these, before those that are wanted
  std::vector<SeenMessage> seen_;          // of one time
  std::map<std::size_t, Latched> latched_; // of channels of the output
  std::size_t other_messages_ = 0;
  std::size_t common_messages_ = 0; // that were copied once
  std::size_t left_out_ = 0;        // other messages that the output cannot have
  std::size_t lost_ = 0;
};

} // namespace pcl_ext::tools

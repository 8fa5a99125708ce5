// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "commands/encode_summary.h"
#include "console/console.h"
#include "inputs/cloud_input.h"
#include "options/encoding_options.h"
#include "outputs/frame_output.h"
#include "outputs/output_path.h"
#include "streams/crew.h"
#include "streams/encoded_stream.h"
#include "streams/frame_failures.h"

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief What `pcl_ext encode` is asked for. */
struct EncodeOptions {
  InputOptions input;
  EncodingOptions encoding;
  Output output;
  bool is_quiet = false;
  bool is_json = false;
  bool reports_progress = false;     // for programs
  unsigned int jobs = 1;             ///< threads that encode
  std::vector<std::string> left_out; ///< paths in folders of bags
};

/** \brief Encodes all clouds of an input into one output: files, or a bag with its other
 * messages. Clouds are read and frames written in the order of the input, by the thread
 * that calls; a crew encodes. */
class BagEncoding {
public:
  /** \param[in] options it, console and crew must outlive this
   * \param[in] jobs how many of the crew's threads may be for this input
   */
  BagEncoding(const EncodeOptions& options,
              Console& console,
              Crew& crew,
              unsigned int jobs);
  ~BagEncoding();

  /** \brief Does it.
   * \return the exit status
   * \throws UsageError if the options are not for this input
   * \throws std::runtime_error if nothing could be encoded, or writing fails
   */
  int
  run();

  /** \brief What was done. */
  const BagSummary&
  summary() const
  {
    return summary_;
  }

private:
  struct Stream;

  /** \brief A message that is not encoded, or a cloud: what is written next. */
  struct InFlight {
    std::shared_ptr<CloudInWork> cloud; // null: a message
    recording::McapMessage message;
    std::optional<std::size_t> place; // of a message that is unread
  };

  bool
  passesThrough(const recording::McapChannel& channel) const;

  void
  checkNumberOfStreams() const;

  void
  shareTopics();

  void
  addStreams();

  std::string
  topicOfFrames(const std::string& name);

  template <typename StepT>
  void
  tryOn(std::size_t number, const StepT& step);

  void
  encodeAll();

  void
  take(const std::shared_ptr<CloudInWork>& cloud);

  std::shared_ptr<CloudInWork>
  unusedCloud();

  void
  queue(const std::vector<std::shared_ptr<CloudInWork>>& clouds);

  void
  writeUntil(std::size_t most_clouds, std::size_t most_bytes);

  void
  write(CloudInWork& cloud);

  void
  writeFrame(Stream& stream, CloudInWork& cloud);

  std::size_t
  addStream(std::size_t number);

  void
  passThrough(recording::McapMessage& message);

  void
  sumUp();

  std::string
  whyNoFrames() const;

  int
  finish();

  double
  bytesASecond() const;

  const EncodeOptions& options_;
  Console& console_;
  Crew& crew_;
  unsigned int jobs_;
  std::size_t most_clouds_; // in flight
  FrameFailures failures_;
  std::unique_ptr<CloudInput> input_;
  std::optional<FrameOutput> output_;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::vector<std::optional<std::size_t>> other_channels_; // of the input's channels
  std::set<std::string> stream_topics_; // of frames that were written to a bag
  std::deque<InFlight> in_flight_;      // not written yet
  std::size_t clouds_in_flight_ = 0;
  std::size_t bytes_in_flight_ = 0;           // of messages
  std::shared_ptr<PlaceReader> other_reader_; // if they are left unread
  bool has_clouds_ = false;                   // that may have failed
  bool is_cut_ = false; // by an interruption before a cloud was read
  std::vector<std::shared_ptr<CloudInWork>> unused_; // so that their memory is reused
  bool is_incomplete_ = false;
  std::size_t left_out_ = 0; // messages of other topics that the output cannot have
  BagSummary summary_;
};

} // namespace pcl_ext::tools

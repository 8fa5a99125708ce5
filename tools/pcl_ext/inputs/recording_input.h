// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_reader.h>

#include "inputs/stream_metadata.h"
#include "inputs/viewpoints.h"
#include "options/text_values.h"
#include "recording/bag_reader.h"

#include <CLI/App.hpp>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

inline double
secondsOf(recording::Time time)
{
  return std::chrono::duration<double>(time).count();
}

/** \brief Which frames of a recording are wanted; all conditions together. */
struct Selection {
  FrameRange frames;                ///< of each stream
  std::optional<double> from;       ///< seconds from the start of the recording
  std::optional<double> to;         ///< seconds; frames at this time are not wanted
  std::vector<std::string> streams; ///< empty: all

  /** \brief True if frames are chosen by number or time. */
  bool
  hasRange() const
  {
    return from || to || frames.begin > 0 || frames.end != FrameRange().end;
  }
};

/** \brief Adds --frames, --from, --to and --streams. */
void
addSelection(CLI::App& app, Selection& selection);

/** \brief The wanted frames of a recording, and the other messages of a bag, in the
 * order of their times. Failures throw std::exception. */
class RecordingInput {
public:
  /** \brief A frame, or another message of the bag. */
  struct Item {
    bool is_frame = false;
    std::size_t stream = 0;
    std::size_t number = 0;  ///< of the frame in its stream
    bool is_wanted = true;   ///< false: frames that only lead from an I-frame to others
    std::size_t message = 0; ///< index in bag()->index(), if there is one
    bool has_message = false; ///< of frames, in CDR
    recording::Time time{0};
  };

  /** \brief Opens a recording.
   * \param[in] path of it; - is the standard input
   */
  explicit RecordingInput(const std::string& path);

  /** \brief The same with messages of the streams and of other topics, if it is a
   * bag. */
  static RecordingInput
  openBag(const std::string& path);

  const std::string&
  path() const
  {
    return path_;
  }

  std::string
  shownPath() const;

  /** \brief Name of a stream; that of a copied input follows from what the user
   * gave. */
  const std::string&
  nameOf(std::size_t stream) const
  {
    return new_name_.empty() ? reader_.streams()[stream].name : new_name_;
  }

  /** \brief Gives a recording's only stream another name. */
  void
  nameStream(const std::string& name)
  {
    new_name_ = name;
  }

  /** \brief What the channel of a stream tells of it. */
  const StreamMetadata&
  metadataOf(std::size_t stream) const
  {
    const auto found = new_metadata_.find(stream);
    return found != new_metadata_.end() ? found->second
                                        : reader_.streams()[stream].metadata;
  }

  /** \brief Gives a stream the viewpoints of all its parts. */
  void
  setViewpoints(std::size_t stream, const Viewpoints& viewpoints)
  {
    StreamMetadata metadata = metadataOf(stream);
    metadata.erase(viewpoint_metadata);
    viewpoints.addTo(metadata);
    new_metadata_[stream] = std::move(metadata);
  }

  recording::RecordingReader&
  reader()
  {
    return reader_;
  }

  /** \brief The bag; null: the recording is none, or was not opened as one. */
  recording::BagReader*
  bag()
  {
    return bag_ ? &*bag_ : nullptr;
  }

  /** \brief True for channels of bag() that are streams. */
  bool
  isStream(std::size_t channel) const
  {
    return stream_of_channel_[channel] != none;
  }

  /** \brief Chooses frames; without, all are chosen. Messages of other topics are those
   * from the first of these frames on until the next ones; before the first frames of
   * the recording, and after the last ones, all. Latched ones from before the chosen
   * frames are at the time of the first one.
   * \throws UsageError if there are no such frames
   */
  void
  select(const Selection& selection);

  /** \brief Leaves out the frames of a stream from a number on. */
  void
  endBefore(std::size_t stream, std::size_t number)
  {
    ranges_[stream].end = std::min(ranges_[stream].end, number);
  }

  /** \brief True if frames of a stream are wanted. */
  bool
  isChosen(std::size_t stream) const
  {
    return ranges_[stream].wanted < ranges_[stream].end;
  }

  /** \brief Number of frames and messages that next() will return. */
  std::size_t
  size() const;

  /** \brief Number of the wanted frames alone. */
  std::size_t
  wantedFrames() const;

  /** \brief Finds what is next; false at the end. */
  bool
  next(Item& item);

  /** \brief Reads a frame. */
  recording::RecordingStatus
  read(const Item& item, recording::RecordedFrame& frame);

  recording::RecordingStatus
  read(const Item& item, recording::McapMessage& message);

  /** \brief The time from which seconds count. */
  recording::Time
  start() const;

  /** \brief What could not be read until now, a line each. */
  std::vector<std::string>
  damage() const;

  /** \brief That the recording was not finished; empty if it was. */
  std::string
  unfinishedRemark() const;

private:
  static constexpr std::size_t none = ~std::size_t{0};

  /** \brief Frames of a stream. */
  struct Range {
    bool is_of_named = false; ///< of a stream that is chosen by name
    std::size_t begin = 0;    ///< an I-frame
    std::size_t wanted = 0;   ///< the first one that is wanted; end: none is
    std::size_t end = 0;
    std::size_t next = 0;
  };

  void
  indexBag();

  Range
  rangeOf(std::size_t stream, const Selection& selection);

  void
  selectOthers(const Selection& selection);

  std::string path_;
  std::string new_name_; // of the only stream; empty: its own
  std::map<std::size_t, StreamMetadata> new_metadata_; // of streams
  recording::RecordingReader reader_;
  std::optional<recording::BagReader> bag_;
  std::vector<std::size_t> stream_of_channel_; // of the bag; or none
  // Of each stream in the order of its frames, in bag_->index().
  std::vector<std::vector<std::size_t>> messages_;
  std::vector<std::size_t> others_;                       // likewise
  std::vector<Range> ranges_;                             // of each stream
  std::vector<std::size_t> chosen_others_;                // of others_
  std::size_t next_other_ = 0;                            // of these
  recording::Time others_begin_ = recording::Time::min(); // earlier ones get this time
};

/** \brief A line for a place that could not be read. Damage of a whole file, and that of
 * a database, names no byte. */
std::string
describe(const recording::RecordingDamage& damage);

} // namespace pcl_ext::tools

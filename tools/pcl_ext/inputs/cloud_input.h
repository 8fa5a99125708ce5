// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "clouds/cloud_sequence.h"
#include "inputs/standard_input.h"
#include "inputs/viewpoints.h"
#include "options/text_values.h"
#include "recording/bag_reader.h"
#include "recording/mcap_content.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext::tools {

class FrameOutput;

/** \brief A cloud of the input of a command, or why it could not be read. */
struct InputCloud {
  std::size_t stream = 0;         ///< index in CloudInput::streams()
  std::size_t number = 0;         ///< in its stream, from 0
  std::string source;             ///< file or topic and number, for messages
  std::string failure;            ///< empty: the cloud was read
  bool is_refused = false;        ///< it failed as the options are not for it
  bool is_unread = false;         ///< the following are not set but for log_time
  std::size_t place = 0;          ///< in the index of a bag, if it is unread
  recording::McapMessage message; ///< its times and sequence number; no bytes
  recording::Time stamp{0};       ///< of the cloud
  std::string remark;             ///< what is taken otherwise than it is there
  std::string colour_remark;      ///< whether colours of a message are clamped
  /** \brief Of the colours of messages of the stream: as the clouds until the first one
   * with points tell it. Reading a message sets what they do not. */
  clouds::ColourScale colour_scale;
  pcl::PCLPointCloud2 cloud;
};

/** \brief Reads clouds and messages that CloudInput::next() left unread, for one
 * thread. */
class PlaceReader {
public:
  virtual ~PlaceReader() = default;

  /** \brief Reads a cloud, or sets why it cannot be read. */
  virtual void
  read(InputCloud& cloud) = 0;

  /** \brief Reads a message of another topic.
   * \param[in,out] message its channel is known
   * \return false if it cannot be read, which CloudInput::damage() tells
   */
  virtual bool
  read(std::size_t place, recording::McapMessage& message) = 0;
};

/** \brief Where clouds come from: files, or a bag. */
class CloudInput {
public:
  /** \brief What next() found. */
  enum class Found { Cloud, OtherMessage, Extra, End };

  virtual ~CloudInput() = default;

  /** \brief Names of the streams; of a pipe until now. */
  virtual const std::vector<std::string>&
  streams() const = 0;

  /** \brief Number of clouds and messages in all, for progress; 0: it is not known
   * yet. */
  virtual std::size_t
  size() const = 0;

  /** \brief Reads what is next in time.
   * \param[out] cloud with Cloud
   * \param[out] other with OtherMessage: a message to pass through; its channel is an
   * index in channels() With Extra copyExtra() has what was found.
   */
  virtual Found
  next(InputCloud& cloud, recording::McapMessage& other) = 0;

  /** \brief Lets next() leave clouds and messages unread, so that several threads read.
   * \return false: all are read by next()
   */
  virtual bool
  leaveUnread()
  {
    return false;
  }

  /** \brief A reader of what is unread; may be called by several threads, and readers
   * used at once, as long as this exists. */
  virtual std::shared_ptr<PlaceReader>
  placeReader()
  {
    return nullptr;
  }

  /** \brief Copies the metadata or the attachment that next() found. */
  virtual void
  copyExtra(FrameOutput& /* output */)
  {}

  /** \brief True if clouds come while somebody writes them into a pipe. */
  virtual bool
  isLive() const
  {
    return false;
  }

  /** \brief Sets what is done before next() waits for somebody to write. */
  virtual void
  setBeforeWaiting(std::function<void()> /* action */)
  {}

  /** \brief True if there may be messages, metadata and attachments to pass through. */
  virtual bool
  isBag() const
  {
    return false;
  }

  /** \brief Profile for the output, see McapWriter::open(). */
  virtual std::string
  profile() const
  {
    return "ros2";
  }

  /** \brief Channels of a bag; of a pipe until now. */
  virtual const std::vector<recording::McapChannel>&
  channels() const
  {
    static const std::vector<recording::McapChannel> none;
    return none;
  }

  /** \brief True if nothing tells the times of a stream's clouds, which follow from the
   * usual rate of InputOptions then. */
  virtual bool
  assumesTimes(std::size_t /* stream */) const
  {
    return false;
  }

  /** \brief VIEWPOINTs of the files of a stream. */
  virtual Viewpoints
  viewpointsOf(std::size_t /* stream */) const
  {
    return {};
  }

  /** \brief The bag, for its metadata and attachments; null: there is none. */
  virtual recording::BagReader*
  bag()
  {
    return nullptr;
  }

  /** \brief What could not be read until now, a line each. */
  virtual std::vector<std::string>
  damage() const
  {
    return {};
  }

  /** \brief What of the input was left out, or may be another than the user thinks, a
   * line each. */
  virtual std::vector<std::string>
  remarks() const
  {
    return {};
  }

  /** \brief What of the clouds that were read until now is left out, or taken otherwise
   * than it is in the input, a line each. */
  virtual std::vector<std::string>
  remarksOnClouds() const
  {
    return {};
  }
};

struct InputOptions {
  std::vector<std::string> inputs; ///< as the user gave them; - is the standard input
  double rate = 10.0;           ///< clouds a second, where names of files have no times
  bool has_rate = false;        ///< the user gave one
  bool may_have_streams = true; ///< the output takes more than one
  FrameRange frames;            ///< of each stream
  std::vector<std::string> topics;           ///< of a bag; empty: all clouds
  std::vector<clouds::FileField> bin_fields; ///< of .bin files; empty: by their names
  /** \brief Separate channels of messages, as r, g and b, are a colour; files have
   * theirs always. */
  bool packs_colours = true;
  clouds::LongIntegers long_integers; ///< of files
};

/** \brief Why none of the clouds are wanted. */
inline std::string
describeFramesBeyond(const InputOptions& options, std::size_t longest_stream)
{
  return "--frames begins at " + std::to_string(options.frames.begin) +
         ", and the longest stream has " + counted(longest_stream, "cloud");
}

/** \brief Opens files, folders, globs of them, or a bag.
 * \throws std::exception with a message for the user
 */
std::unique_ptr<CloudInput>
openInput(const InputOptions& options);

/** \brief Opens files and folders. */
std::unique_ptr<CloudInput>
openFiles(const std::vector<clouds::SequenceInput>& paths, const InputOptions& options);

/** \brief Opens a file that BagReader takes, or a rosbag2 folder. */
std::unique_ptr<CloudInput>
openBag(const std::string& path, const InputOptions& options);

/** \brief Opens an MCAP file that comes through a pipe.
 * \param[in] descriptor of the pipe, after the first 8 bytes
 * \param[in] name of the pipe, for messages
 */
std::unique_ptr<CloudInput>
openMcapPipe(recording::Descriptor descriptor,
             const std::string& name,
             const InputOptions& options);

/** \brief Checks the topics that the user chose.
 * \param[in] topics those of the clouds of a bag
 * \throws UsageError if one is not among them
 */
void
checkTopics(const std::vector<std::string>& chosen,
            const std::vector<std::string>& topics);

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_sequence.h"
#include "console/exit_status.h"
#include "inputs/cloud_input.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

namespace pcl_ext::tools {

namespace {

namespace fs = std::filesystem;

using clouds::CloudSequence;
using recording::Time;

/** \brief Files and folders: the first cloud of each stream, the second of each, and so
 * on.
 */
class FileInput : public CloudInput {
public:
  FileInput(std::vector<std::unique_ptr<CloudSequence>> sequences,
            std::vector<std::string> remarks,
            const InputOptions& options)
  : sequences_(std::move(sequences))
  , remarks_(std::move(remarks))
  , options_(options)
  , index_(options.frames.begin)
  {
    for (const auto& sequence : sequences_) {
      streams_.push_back("/" + sequence->name());
      if (const std::string remark = sequence->remark(); !remark.empty())
        remarks_.push_back(remark);
      const std::size_t end = std::min(sequence->size(), options.frames.end);
      end_ = std::max(end_, end);
      size_ += end - std::min(end, options.frames.begin);
    }
    if (size_ == 0)
      throw UsageError(describeFramesBeyond(options, end_));
  }

  const std::vector<std::string>&
  streams() const override
  {
    return streams_;
  }

  std::size_t
  size() const override
  {
    return size_;
  }

  std::vector<std::string>
  remarks() const override
  {
    return remarks_;
  }

  std::vector<std::string>
  remarksOnClouds() const override
  {
    std::vector<std::string> remarks;
    for (std::size_t stream = 0; stream < sequences_.size(); ++stream)
      for (const std::string& remark : sequences_[stream]->remarksOnClouds())
        remarks.push_back(streams_[stream] + ": " + remark);
    return remarks;
  }

  bool
  assumesTimes(std::size_t stream) const override
  {
    return !options_.has_rate && !sequences_[stream]->stampAt(0);
  }

  Viewpoints
  viewpointsOf(std::size_t stream) const override
  {
    Viewpoints viewpoints;
    const std::size_t end = std::min(sequences_[stream]->size(), end_);
    for (std::size_t index = options_.frames.begin; index < end; ++index)
      viewpoints.add(stampOf(stream, index), sequences_[stream]->viewpointAt(index));
    return viewpoints;
  }

  Found
  next(InputCloud& cloud, recording::McapMessage& /* other */) override
  {
    while (index_ < end_) {
      const std::size_t stream = stream_;
      const std::size_t index = index_;
      stream_ = (stream_ + 1) % sequences_.size();
      index_ += stream_ == 0 ? 1 : 0;
      if (index >= std::min(sequences_[stream]->size(), end_))
        continue;
      read(stream, index, cloud);
      return Found::Cloud;
    }
    return Found::End;
  }

private:
  /** \brief The stamp in the name of a cloud's file, unless the user gave a rate. */
  Time
  stampOf(std::size_t stream, std::size_t index) const
  {
    const auto stamp = sequences_[stream]->stampAt(index);
    return stamp && !options_.has_rate
               ? *stamp
               : Time(std::llround(1e9 * static_cast<double>(index) / options_.rate));
  }

  void
  read(std::size_t stream, std::size_t index, InputCloud& cloud)
  {
    cloud.stream = stream;
    cloud.number = index;
    cloud.source = streams_[stream] + ", frame " + std::to_string(index);
    cloud.failure.clear();
    cloud.is_refused = false;
    cloud.stamp = stampOf(stream, index);
    cloud.message.log_time = cloud.stamp;
    cloud.message.publish_time = cloud.stamp;
    cloud.message.sequence = static_cast<std::uint32_t>(index);
    try {
      sequences_[stream]->read(index, cloud.cloud);
    }
    catch (const clouds::FieldRefusal& error) {
      cloud.failure = std::string("--fields: ") + error.what();
      cloud.is_refused = true;
    }
    catch (const std::exception& error) {
      cloud.failure = error.what();
    }
    cloud.cloud.header.stamp = static_cast<std::uint64_t>(cloud.stamp.count() / 1000);
  }

  std::vector<std::unique_ptr<CloudSequence>> sequences_;
  std::vector<std::string> remarks_;
  InputOptions options_;
  std::vector<std::string> streams_;
  std::size_t size_ = 0;
  std::size_t end_ = 0;
  std::size_t stream_ = 0; // of the next cloud
  std::size_t index_;      // of the next cloud in its stream
};

/** \brief What is left out of folders, and whether files of several folders are one
 * stream.
 */
std::vector<std::string>
remarksOn(const std::vector<clouds::SequenceInput>& paths, bool may_have_streams)
{
  std::vector<std::string> remarks;
  std::set<fs::path> folders; // of files
  for (const auto& [path, name] : paths) {
    if (!fs::is_directory(path))
      folders.insert(fs::path(name).parent_path());
    else if (const std::string ignored = clouds::describeIgnored(path);
             !ignored.empty())
      remarks.push_back("'" + name + "': left out: " + ignored +
                        "; each folder that is named is a stream");
  }
  if (folders.size() > 1 && !may_have_streams)
    remarks.push_back("files of " + counted(folders.size(), "folder") +
                      " become one stream; a stream for each folder needs x.mcap");
  return remarks;
}

} // namespace

std::unique_ptr<CloudInput>
openFiles(const std::vector<clouds::SequenceInput>& paths, const InputOptions& options)
{
  if (!options.topics.empty())
    throw UsageError("--topics is for bags, and these are files");
  if (!options.bin_fields.empty() &&
      std::none_of(paths.begin(), paths.end(), [](const clouds::SequenceInput& input) {
        return clouds::hasBinFile(input.path);
      }))
    throw UsageError("--bin-fields is for files without a header, such as .bin, and "
                     "there are none");
  return std::make_unique<FileInput>(
      clouds::openSequences(paths,
                            0,
                            options.may_have_streams
                                ? clouds::FileGrouping::ByFolder
                                : clouds::FileGrouping::OneSequence,
                            options.bin_fields,
                            options.long_integers),
      remarksOn(paths, options.may_have_streams),
      options);
}

} // namespace pcl_ext::tools

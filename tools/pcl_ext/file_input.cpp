#include "cloud_input.h"
#include "exit_status.h"
#include "measuring/cloud_sequence.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace tools {

namespace {

using measuring::CloudSequence;
using recording::Time;

/** \brief Files and folders: the first cloud of each stream, the second of each, and so on.
 */
class FileInput : public CloudInput {
public:
  FileInput(std::vector<std::unique_ptr<CloudSequence>> sequences,
            const InputOptions& options)
  : sequences_(std::move(sequences)), options_(options), index_(options.frames.begin)
  {
    for (const auto& sequence : sequences_) {
      streams_.push_back("/" + sequence->name());
      const std::size_t end = std::min(sequence->size(), options.frames.end);
      end_ = std::max(end_, end);
      size_ += end - std::min(end, options.frames.begin);
    }
    if (size_ == 0)
      throw UsageError("--frames begins at " + std::to_string(options.frames.begin) +
                       ", and the longest stream has " + std::to_string(end_) +
                       " clouds");
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
  void
  read(std::size_t stream, std::size_t index, InputCloud& cloud)
  {
    cloud.stream = stream;
    cloud.number = index;
    cloud.source = sequences_[stream]->name() + ", frame " + std::to_string(index);
    cloud.failure.clear();
    cloud.stamp = Time(std::llround(1e9 * static_cast<double>(index) / options_.rate));
    cloud.message.log_time = cloud.stamp;
    cloud.message.publish_time = cloud.stamp;
    cloud.message.sequence = static_cast<std::uint32_t>(index);
    try {
      sequences_[stream]->read(index, cloud.cloud);
    }
    catch (const std::exception& error) {
      cloud.failure = error.what();
    }
    cloud.cloud.header.stamp = static_cast<std::uint64_t>(cloud.stamp.count() / 1000);
  }

  std::vector<std::unique_ptr<CloudSequence>> sequences_;
  InputOptions options_;
  std::vector<std::string> streams_;
  std::size_t size_ = 0;
  std::size_t end_ = 0;
  std::size_t stream_ = 0; // of the next cloud
  std::size_t index_;      // of the next cloud in its stream
};

} // namespace

std::unique_ptr<CloudInput>
openFiles(const std::vector<std::string>& paths, const InputOptions& options)
{
  if (!options.topics.empty())
    throw UsageError("--topics is for bags, and these are files");
  std::vector<std::unique_ptr<CloudSequence>> sequences =
      measuring::openSequences(paths, 0);
  // A file without a name has that of its place in the system.
  if (std::find(options.inputs.begin(), options.inputs.end(), "-") !=
      options.inputs.end())
    sequences.back()->rename("stdin");
  return std::make_unique<FileInput>(std::move(sequences), options);
}

} // namespace tools
} // namespace pcl_ext

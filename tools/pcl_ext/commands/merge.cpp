// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/recording_input.h"
#include "options/options.h"
#include "outputs/copied_streams.h"
#include "outputs/output_path.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

namespace pcl_ext::tools {

namespace {

using recording::RecordedStream;
using recording::Time;

struct MergeOptions {
  std::vector<std::string> inputs;
  Output output;
  std::vector<std::string> prefixes;
  bool is_quiet = false;
};

/** \brief The part of a stream that is in one input. */
struct Part {
  RecordingInput* input;
  std::size_t stream; // of the input

  const RecordedStream&
  recorded() const
  {
    return input->reader().streams()[stream];
  }
};

std::string
prefixOf(const MergeOptions& options, std::size_t input)
{
  if (options.prefixes.empty() || options.prefixes[input].empty())
    return {};
  const std::string& prefix = options.prefixes[input];
  return prefix.front() == '/' ? prefix : "/" + prefix;
}

/** \brief True if a part has from a frame on the same frames as another one from its
 * beginning, byte for byte, until one of them ends. */
bool
isRepeatedFrom(std::size_t begin, const Part& before, const Part& after)
{
  recording::RecordedFrame one;
  recording::RecordedFrame other;
  const std::size_t frames = before.recorded().frames;
  for (std::size_t i = 0; begin + i < frames && i < after.recorded().frames; ++i)
    if (!before.input->reader().read(before.stream, begin + i, one).ok() ||
        !after.input->reader().read(after.stream, i, other).ok() ||
        one.bytes != other.bytes)
      return false;
  return true;
}

/** \brief Number of the frame from which on a part has the frames that another one begins
 * with. So do the parts that `cut` makes between two I-frames. Nothing if there is no
 * such frame.
 */
std::optional<std::size_t>
beginOfRepetition(const Part& before, const Part& after)
{
  recording::RecordingReader& first = before.input->reader();
  if (!before.recorded().has_times) {
    // The same frames from the beginning on may be another recording.
    if (isRepeatedFrom(0, before, after))
      return 0;
    const std::size_t begin =
        first.iFrameBefore(before.stream, before.recorded().frames - 1);
    return isRepeatedFrom(begin, before, after) ? std::optional(begin) : std::nullopt;
  }
  const std::optional<std::size_t> last =
      first.frameAt(before.stream, after.recorded().first_time);
  if (!last)
    return std::nullopt;
  // Several frames may be of one time.
  const Time time = first.timeOf(before.stream, *last);
  for (std::size_t begin = *last;; --begin) {
    if (isRepeatedFrom(begin, before, after))
      return begin;
    if (begin == 0 || first.timeOf(before.stream, begin - 1) != time)
      return std::nullopt;
  }
}

/** \brief Leaves out frames that two parts of a stream have, in one of them, and says so.
 * \param[in] files those of the parts, for messages
 * \param[in] name of the stream
 * \return whether there are any
 */
bool
leaveOutRepetition(const Part& before,
                   const Part& after,
                   const std::string& files,
                   const std::string& name,
                   Console& console)
{
  const std::optional<std::size_t> begin = beginOfRepetition(before, after);
  if (!begin)
    return false;
  const std::size_t repeated =
      std::min(before.recorded().frames - *begin, after.recorded().frames);
  // The first frames of two recordings of a still scene may be the same, too.
  if (!before.recorded().has_times && *begin == 0) {
    console.remark(files + " begin with the same " + counted(repeated, "frame") +
                   " of " + name +
                   ", which have no times to tell whether they are the same ones: all "
                   "are copied");
    return false;
  }
  if (repeated == after.recorded().frames)
    after.input->endBefore(after.stream, 0);
  else
    before.input->endBefore(before.stream, *begin);
  console.remark(files + " have " + counted(repeated, "frame") + " of " + name +
                 " in common, copied once");
  return true;
}

/** \brief Says where two files of frames, which become streams of their own, are
 * overlapping parts of one stream. */
void
noteSeparateParts(const std::vector<Part>& files, Console& console)
{
  for (const Part& before : files)
    for (const Part& after : files) {
      if (&before == &after || before.recorded().frames == 0)
        continue;
      const std::optional<std::size_t> begin = beginOfRepetition(before, after);
      // Recordings of a still scene may begin with the same frames.
      if (begin && *begin > 0)
        console.remark("'" + before.input->shownPath() + "' ends with frames that '" +
                       after.input->shownPath() +
                       "' begins with, and both become streams: name x.pcxi as the "
                       "output to join them");
    }
}

/** \brief What a part's metadata has for a key, for messages too. */
std::string
valueOf(const Part& part, const char* key)
{
  const StreamMetadata& metadata = part.recorded().metadata;
  const auto found = metadata.find(key);
  return found == metadata.end() ? "not told" : found->second;
}

/** \brief Checks that all parts of a stream tell the same of its clouds.
 * \throws UsageError if they do not
 */
void
checkMetadata(const std::string& name,
              const std::vector<Part>& parts,
              const std::string& output)
{
  const auto textOf = [](const Part& part, const char* key) {
    return "'" + part.input->shownPath() + "' (" + valueOf(part, key) + ")";
  };
  for (const Part& part : parts)
    for (const char* key : cloud_metadata)
      if (valueOf(part, key) != valueOf(parts.front(), key))
        throw UsageError("the stream " + name + " has another " + key + " in " +
                         textOf(part, key) + " than in " + textOf(parts.front(), key) +
                         (kindOfOutput(output) == OutputKind::Frames
                              ? ": name x.mcap as the output and tell them apart"
                              : ": tell them apart") +
                         " with --prefix, such as --prefix a,b");
}

/** \brief Gives the parts of one stream, in the order of their times, the viewpoints of
 * all. */
void
joinViewpoints(const std::vector<Part>& parts)
{
  // As parts that `cut` makes have those of the whole recording.
  if (std::all_of(parts.begin(), parts.end(), [&parts](const Part& part) {
        return valueOf(part, viewpoint_metadata) ==
               valueOf(parts.front(), viewpoint_metadata);
      }))
    return;
  Viewpoints joined;
  for (const Part& part : parts)
    if (part.input->isChosen(part.stream))
      joined.append(Viewpoints(part.recorded().metadata),
                    part.recorded().first_time,
                    part.recorded().last_time);
  for (const Part& part : parts)
    part.input->setViewpoints(part.stream, joined);
}

/** \brief Puts the parts of one stream one after the other.
 * \throws UsageError if they are of the same time, or tell different things of the clouds
 */
void
joinParts(const std::string& name,
          std::vector<Part> parts,
          const std::string& output,
          Console& console)
{
  checkMetadata(name, parts, output);
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return a.recorded().first_time < b.recorded().first_time;
  });
  std::size_t last = 0; // of the parts until now, the one that ends last
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const RecordedStream& before = parts[last].recorded();
    const RecordedStream& after = parts[i].recorded();
    const bool have_times = before.has_times && after.has_times;
    const bool have_none = !before.has_times && !after.has_times;
    if (have_times && before.last_time < after.first_time) {
      last = i;
      continue;
    }
    const std::string first = "'" + parts[last].input->shownPath() + "'";
    const std::string second = "'" + parts[i].input->shownPath() + "'";
    const bool is_repeated =
        (have_times || have_none) &&
        leaveOutRepetition(
            parts[last], parts[i], first + " and " + second, name, console);
    // Without times the parts follow each other as they were named.
    if (is_repeated || have_none) {
      last = parts[i].input->isChosen(parts[i].stream) ? i : last;
      continue;
    }
    const std::string files = first + " and in " + second;
    if (kindOfOutput(output) == OutputKind::Frames)
      throw UsageError("'" + output +
                       "' has one stream, and there are other frames of the same time "
                       "in " +
                       files + ": name x.mcap as the output");
    throw UsageError("the stream " + name + " has other frames of the same time in " +
                     files + ": tell them apart with --prefix, such as --prefix a,b");
  }
  joinViewpoints(parts);
}

class Merge {
public:
  explicit Merge(const MergeOptions& options)
  : options_(options), console_("merge", options.is_quiet)
  {
    const std::string& path = options.output.path;
    if (path == "-")
      console_.keepOutputFree();
    checkOutput(path);
    if (kindOfOutput(path) == OutputKind::Frames && !options.prefixes.empty())
      throw UsageError(
          "--prefix has no effect on '" + path +
          "', which has no names of streams: name x.mcap, or leave it out");
    if (!options.prefixes.empty() && options.prefixes.size() != options.inputs.size())
      throw UsageError("--prefix needs a name for each of the " +
                       std::to_string(options.inputs.size()) + " inputs");
    refuseTakenFile(options.inputs, path, options.output.may_replace);
    for (const std::string& input : options.inputs)
      inputs_.push_back(
          std::make_unique<RecordingInput>(RecordingInput::openBag(input)));
    joinStreams();
  }

  int
  run()
  {
    const auto bag =
        std::find_if(inputs_.begin(), inputs_.end(), [](const auto& input) {
          return input->bag() != nullptr;
        });
    CopiedStreams copied(options_.output,
                         bag != inputs_.end(),
                         bag != inputs_.end() ? (*bag)->bag() : nullptr,
                         console_);
    std::size_t items = 0;
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      copied.addInput(*inputs_[i], prefixOf(options_, i));
      items += inputs_[i]->size();
    }
    console_.startProgress("frames", items);
    std::vector<Next> next(inputs_.size());
    for (std::size_t i = 0; i < next.size(); ++i)
      next[i].is_valid = inputs_[i]->next(next[i].item);
    while (!isInterrupted()) {
      const std::size_t earliest = earliestOf(next);
      if (earliest == next.size())
        break;
      copied.copy(earliest, next[earliest].item);
      next[earliest].is_valid = inputs_[earliest]->next(next[earliest].item);
      console_.advance();
    }
    return copied.finish();
  }

private:
  struct Next {
    RecordingInput::Item item;
    bool is_valid = false;
  };

  static std::size_t
  earliestOf(const std::vector<Next>& next)
  {
    std::size_t earliest = next.size();
    for (std::size_t i = 0; i < next.size(); ++i)
      if (next[i].is_valid &&
          (earliest == next.size() || next[i].item.time < next[earliest].item.time))
        earliest = i;
    return earliest;
  }

  /** \brief True if files of frames become one: their names do not tell streams apart. */
  bool
  isOneStream() const
  {
    return kindOfOutput(options_.output.path) == OutputKind::Frames &&
           std::all_of(inputs_.begin(), inputs_.end(), [](const auto& input) {
             return input->bag() == nullptr;
           });
  }

  void
  joinStreams()
  {
    if (isOneStream())
      for (const auto& input : inputs_)
        input->nameStream("/stream");
    std::map<std::string, std::vector<Part>> parts;
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      for (std::size_t stream = 0; stream < inputs_[i]->reader().streams().size();
           ++stream)
        parts[topicName(prefixOf(options_, i), inputs_[i]->nameOf(stream))].push_back(
            {inputs_[i].get(), stream});
    for (const auto& [name, of_name] : parts)
      joinParts(name, of_name, options_.output.path, console_);
    std::vector<Part> files; // of streams of their own
    for (const auto& [name, of_name] : parts)
      if (of_name.size() == 1 && of_name.front().input->bag() == nullptr)
        files.push_back(of_name.front());
    noteSeparateParts(files, console_);
    if (kindOfOutput(options_.output.path) == OutputKind::Frames && parts.size() > 1)
      throw UsageError("'" + options_.output.path +
                       "' takes one stream, and there are " +
                       std::to_string(parts.size()) + ": name x.mcap");
  }

  MergeOptions options_;
  Console console_;
  std::vector<std::unique_ptr<RecordingInput>> inputs_;
};

} // namespace

Run
addMerge(CLI::App& app)
{
  const auto options = std::make_shared<MergeOptions>();
  addInput(app, options->inputs, "recordings");
  addOutput(app, options->output, "x.mcap, a folder, or for one stream x.pcxi or -");
  addNames(app,
           "--prefix",
           options->prefixes,
           "for the streams of each input, with commas between them");
  addQuiet(app, options->is_quiet);
  return [options] { return Merge(*options).run(); };
}

} // namespace pcl_ext::tools

#include "commands.h"
#include "console.h"
#include "copied_streams.h"
#include "exit_status.h"
#include "interruption.h"
#include "options.h"
#include "output_path.h"
#include "recording_input.h"

#include <algorithm>
#include <map>
#include <memory>

namespace pcl_ext {
namespace tools {

namespace {

using recording::RecordedStream;
using recording::Time;

struct MergeOptions {
  std::vector<std::string> inputs;
  std::string output;
  std::vector<std::string> prefixes;
  bool is_quiet = false;
};

/** \brief The part of a stream that is in one input. */
struct Part {
  std::size_t input;
  RecordedStream stream;
};

std::string
prefixOf(const MergeOptions& options, std::size_t input)
{
  if (options.prefixes.empty() || options.prefixes[input].empty())
    return {};
  const std::string& prefix = options.prefixes[input];
  return prefix.front() == '/' ? prefix : "/" + prefix;
}

/** \brief Refuses parts of one stream that are not one after the other. */
void
checkParts(const std::string& name,
           const std::vector<Part>& parts,
           const std::vector<std::string>& inputs,
           const std::string& output)
{
  std::vector<Part> sorted = parts;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Part& a, const Part& b) {
    return a.stream.first_time < b.stream.first_time;
  });
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const Part& before = sorted[i - 1];
    const Part& after = sorted[i];
    const bool have_times = before.stream.has_times && after.stream.has_times;
    // Without times the parts follow each other as they were named.
    if (have_times ? before.stream.last_time < after.stream.first_time
                   : !before.stream.has_times && !after.stream.has_times)
      continue;
    const std::string files =
        "'" + inputs[before.input] + "' and in '" + inputs[after.input] + "'";
    if (kindOfOutput(output) == OutputKind::Frames)
      throw UsageError("'" + output +
                       "' has one stream, and there are frames of the same time in " +
                       files + ": name x.mcap as the output");
    throw UsageError("the stream " + name + " is in " + files +
                     " at the same time: tell them apart with --prefix, such as "
                     "--prefix a,b");
  }
}

class Merge {
public:
  explicit Merge(const MergeOptions& options) : options_(options), console_("merge")
  {
    if (options.is_quiet)
      console_.beQuiet();
    if (options.output == "-")
      console_.keepOutputFree();
    checkOutput(options.output);
    if (kindOfOutput(options.output) == OutputKind::Frames && !options.prefixes.empty())
      throw UsageError(
          "--prefix has no effect on '" + options.output +
          "', which has no names of streams: name x.mcap, or leave it out");
    if (!options.prefixes.empty() && options.prefixes.size() != options.inputs.size())
      throw UsageError("--prefix needs a name for each of the " +
                       std::to_string(options.inputs.size()) + " inputs");
    refuseSameFile(options.inputs, options.output);
    for (const std::string& input : options.inputs)
      inputs_.push_back(
          std::make_unique<RecordingInput>(RecordingInput::openBag(input)));
    checkStreams();
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
  /** \brief What an input has next. */
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
    return kindOfOutput(options_.output) == OutputKind::Frames &&
           std::all_of(inputs_.begin(), inputs_.end(), [](const auto& input) {
             return input->bag() == nullptr;
           });
  }

  void
  checkStreams()
  {
    if (isOneStream())
      for (const auto& input : inputs_)
        input->nameStream("/stream");
    std::map<std::string, std::vector<Part>> parts;
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      for (std::size_t stream = 0; stream < inputs_[i]->reader().streams().size();
           ++stream)
        parts[topicName(prefixOf(options_, i), inputs_[i]->nameOf(stream))].push_back(
            {i, inputs_[i]->reader().streams()[stream]});
    for (const auto& [name, of_name] : parts)
      checkParts(name, of_name, options_.inputs, options_.output);
    if (kindOfOutput(options_.output) == OutputKind::Frames && parts.size() > 1)
      throw UsageError("'" + options_.output + "' takes one stream, and there are " +
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
  addOutput(app, options->output, "x.mcap, a folder, or x.pcxi for one stream");
  addNames(app,
           "--prefix",
           options->prefixes,
           "for the streams of each input, with commas between them");
  addQuiet(app, options->is_quiet);
  return [options] { return Merge(*options).run(); };
}

} // namespace tools
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/recording_input.h"
#include "inputs/several_inputs.h"
#include "inputs/standard_input.h"
#include "measuring/markdown_table.h"
#include "options/decoding_options.h"
#include "options/options.h"
#include "streams/frame_failures.h"
#include "streams/loss_count.h"
#include "streams/stream_decoder.h"

#include <memory>

namespace pcl_ext::tools {

namespace {

using measuring::formatted;
using recording::RecordedFrame;
using recording::RecordedStreamDecoder;

struct VerifyOptions {
  std::vector<std::string> inputs;
  Selection selection;
  io::DecoderLimits limits;
  bool is_quiet = false;
};

/** \brief Decodes all frames and prints a line for each one that is lost. */
class Verify {
public:
  /** \param[in] path one of the inputs; lines have its name if there are several */
  Verify(const VerifyOptions& options, const std::string& path, Console& console)
  : console_(console)
  , name_(options.inputs.size() > 1 ? shown(path) + ": " : "")
  , input_(path)
  , limits_(options.limits)
  , failures_([this](const std::string& line) { report(line); })
  {
    input_.select(options.selection);
    for (std::size_t stream = 0; stream < input_.reader().streams().size(); ++stream)
      decoders_.emplace_back(input_.reader(), stream, options.limits)
          .setDecodesVoxels(false);
    gaps_.resize(decoders_.size());
  }

  int
  run()
  {
    console_.startProgress("frames", input_.size());
    RecordingInput::Item item;
    while (!isInterrupted() && input_.next(item)) {
      verify(item);
      console_.advance();
    }
    failures_.finish();
    console_.endProgress();
    remarkOnMemory(limits_, console_);
    std::size_t damaged_places = 0;
    for (const std::string& place : input_.damage()) {
      report("damage: " + place);
      ++damaged_places;
    }
    if (const std::string remark = input_.unfinishedRemark(); !remark.empty())
      report(remark);
    report(
        counted(frames_, "frame") + " decoded, " +
        formatted(static_cast<double>(lost_), 0) + " lost" +
        (damaged_places > 0 ? ", damage at " + counted(damaged_places, "place") : "") +
        (isInterrupted() ? "; interrupted" : ""));
    if (isInterrupted())
      return interrupted;
    return lost_ > 0 || damaged_places > 0 ? something_failed : all_done;
  }

private:
  void
  verify(const RecordingInput::Item& item)
  {
    const auto status = input_.read(item, frame_);
    if (input_.size() == 1)
      console_.status("decoding " +
                      counted(frame_.description.voxels,
                              frame_.description.has_points ? "point" : "voxel"));
    const std::size_t missing = gaps_[item.stream].missingBefore(frame_.description);
    if (!status.ok()) {
      loseFrame(item, status.message());
      return;
    }
    if (missing > 0 && item.is_wanted) {
      lost_ += missing;
      failures_.add(input_.nameOf(item.stream),
                    item.number,
                    " at byte " + std::to_string(frame_.offset),
                    counted(missing, "frame") + " before it " +
                        (missing == 1 ? "is" : "are") + " not in the recording");
    }
    const auto decoded = decoders_[item.stream].decode(frame_, voxels_);
    if (!item.is_wanted)
      return;
    if (decoded.ok())
      ++frames_;
    else
      loseFrame(item, reasonOf(decoded));
  }

  void
  loseFrame(const RecordingInput::Item& item, const std::string& reason)
  {
    ++lost_;
    failures_.add(input_.nameOf(item.stream),
                  item.number,
                  " at byte " + std::to_string(frame_.offset),
                  reason);
  }

  void
  report(const std::string& line)
  {
    console_.summary(name_ + line);
  }

  Console& console_;
  std::string name_; // what lines begin with
  RecordingInput input_;
  io::DecoderLimits limits_;
  FrameFailures failures_;
  std::vector<RecordedStreamDecoder> decoders_; // of each stream
  std::vector<LossCount> gaps_;                 // likewise
  RecordedFrame frame_;
  io::VoxelFrame voxels_;
  std::size_t frames_ = 0;
  std::size_t lost_ = 0;
};

int
verify(const VerifyOptions& options)
{
  Console console("verify", options.is_quiet);
  return forEachInput(options.inputs, console, [&](const std::string& path) {
    return Verify(options, path, console).run();
  });
}

} // namespace

Run
addVerify(CLI::App& app)
{
  const auto options = std::make_shared<VerifyOptions>();
  addInput(app, options->inputs, "recordings; - is standard input");
  addLimits(app, options->limits);
  addSelection(app, options->selection);
  addQuiet(app, options->is_quiet);
  return [options] { return verify(*options); };
}

} // namespace pcl_ext::tools

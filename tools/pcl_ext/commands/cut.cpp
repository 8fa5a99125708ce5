// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/recording_input.h"
#include "options/options.h"
#include "outputs/copied_streams.h"
#include "outputs/frame_output.h"
#include "outputs/output_path.h"

#include <memory>

namespace pcl_ext::tools {

namespace {

struct CutOptions {
  std::string input;
  Output output;
  Selection selection;
  bool is_quiet = false;
};

int
cut(const CutOptions& options)
{
  Console console("cut", options.is_quiet);
  const std::string& path = options.output.path;
  if (path == "-")
    console.keepOutputFree();
  checkOutput(path);
  RecordingInput input = RecordingInput::openBag(options.input);
  refuseTakenFile({input.path()}, path, options.output.may_replace);
  input.select(options.selection);
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < input.reader().streams().size(); ++i)
    chosen += input.isChosen(i) ? 1 : 0;
  if (kindOfOutput(path) == OutputKind::Frames && chosen > 1)
    throw UsageError("'" + path + "' takes one stream, and there are " +
                     std::to_string(chosen) +
                     ": choose one with --streams or name x.mcap");
  CopiedStreams copied(options.output, input.bag() != nullptr, input.bag(), console);
  copied.addInput(input, "");
  console.startProgress("frames", input.size());
  RecordingInput::Item item;
  while (!isInterrupted() && input.next(item)) {
    copied.copy(0, item);
    console.advance();
  }
  return copied.finish();
}

} // namespace

Run
addCut(CLI::App& app)
{
  const auto options = std::make_shared<CutOptions>();
  addInput(app, options->input, "recording; - is standard input");
  addOutput(app, options->output, "x.pcxi or - (one stream), x.mcap, or a folder");
  addSelection(app, options->selection);
  addQuiet(app, options->is_quiet);
  return [options] { return cut(*options); };
}

} // namespace pcl_ext::tools

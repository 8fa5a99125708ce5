// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/node_parameters.h>

#include "advice/stream_trials.h"
#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "console/printable_text.h"
#include "inputs/tried_input.h"
#include "measuring/markdown_table.h"
#include "options/options.h"
#include "options/setting_options.h"
#include "options/text_values.h"
#include "outputs/cloud_folder.h"

#include <algorithm>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <iterator>
#include <memory>
#include <sstream>

namespace pcl_ext::tools {

namespace {

using measuring::formatted;

struct AdviseOptions {
  TriedInput input;
  TrialOptions trials;
  std::string rate_text; ///< --max-rate as the user gave it
  std::vector<GivenOption> given;
  bool is_quiet = false;
};

constexpr const char* most_holes = "25 %";
static_assert(ChoiceLimits::usual_holes == 0.25);

std::string
textOf(double number)
{
  std::ostringstream text;
  text << number;
  return text.str();
}

std::string
percent(double share)
{
  return formatted(100.0 * share, 1) + " %";
}

void
printTable(const StreamTrials& trials)
{
  const Choice& choice = trials.choice;
  measuring::MarkdownTable::Row header = {
      "edge, m", "points a voxel", "holes", "noise"};
  for (const auto& [effort, name] : io::efforts)
    header.insert(header.end(), {std::string(name) + ", kbit/s", "ms"});
  measuring::MarkdownTable table(header);
  for (std::size_t i = 0; i < trials.edges.size(); ++i) {
    const EdgeTrial& trial = trials.edges[i];
    const auto mark = [&](bool is_chosen) {
      return i == choice.edge && is_chosen ? " *" : "";
    };
    measuring::MarkdownTable::Row row = {
        textOf(trial.edge) + mark(true),
        trial.points_a_voxel > 0.0 ? formatted(trial.points_a_voxel, 1) : "in order",
        percent(trial.holes),
        trial.noise ? percent(*trial.noise) : "-"};
    for (const auto& [effort, name] : io::efforts) {
      const auto& tried = trial.efforts[static_cast<std::size_t>(effort)];
      row.push_back(
          tried ? formatted(tried->kilobits, 0) + mark(effort == choice.effort) : "-");
      row.push_back(tried ? formatted(tried->ms, 1) : "-");
    }
    table.addRow(row);
  }
  table.print(std::cout);
}

/** \brief Whether an option is a rate that rate control cannot keep. */
bool
isTooLowARate(const GivenOption& option)
{
  return option.name == "--max-rate" && parseRate(option.value) < io::least_max_rate;
}

/** \brief Given options that the command has, too.
 * \param[in] is_demo it is demo, else encode
 */
std::string
optionsOfCommand(const std::vector<GivenOption>& given, bool is_demo)
{
  std::string text;
  for (const GivenOption& option : given)
    if (const std::string& name = option.name;
        !isTooLowARate(option) && !(is_demo && name == "--max-rate") &&
        name != "--quiet" && name != "--cell" && name != "--topics" &&
        name != "--resolution" && name != "--effort")
      text += ' ' + option.text();
  return text;
}

/** \brief The command line that encodes a stream with a choice. */
std::string
commandOf(const AdviseOptions& options,
          const std::vector<HeldClouds>& streams,
          std::size_t number,
          const std::string& edge,
          const std::string& effort)
{
  const char* const program = std::getenv("PCL_EXT_COMMAND");
  std::string line = program != nullptr ? program : "pcl_ext";
  const std::vector<std::string>& inputs = options.input.input.inputs;
  line += options.input.takes_cell ? " demo --sensors 1" : " encode";
  // Else each input is not one stream.
  const bool is_alone = inputs.size() == streams.size();
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (!is_alone || i == number)
      line += ' ' + quoted(inputs[i]);
  if (!options.input.takes_cell) {
    std::vector<std::string> names;
    for (const HeldClouds& stream : streams)
      names.push_back(stream.name);
    line += " -o small" +
            (streams.size() > 1 ? '_' + folderNames(names)[number] : std::string()) +
            ".mcap";
  }
  if (streams[number].is_topic &&
      (streams.size() > 1 || !options.input.input.topics.empty()))
    line += " --topics " + quoted(streams[number].name);
  return line + " -r " + edge + " -e " + effort +
         optionsOfCommand(options.given, options.input.takes_cell);
}

/** \brief An option as a parameter of sensor_node and the plugin, most of which have the
 * same name; empty if there is none, or another one tells it. */
std::string
parameterOf(const GivenOption& option)
{
  if (option.name == "--sensor" && option.value.find(',') != std::string::npos) {
    std::string text;
    const char* const names[] = {
        "sensor_fov_x_deg", "sensor_fov_y_deg", "sensor_columns", "sensor_rows"};
    const std::vector<double> figures = parseNumbers("sensor", option.value);
    for (std::size_t i = 0; i < std::size(names); ++i)
      text +=
          (i == 0 ? "'" : ", '") + std::string(names[i]) + "': " + textOf(figures[i]);
    return text;
  }
  if (isTooLowARate(option))
    return {};
  if (option.name == "--max-rate") {
    // A number with a point: others have the type of whole numbers in launch files.
    std::ostringstream rate;
    rate << std::fixed << std::setprecision(1) << parseRate(option.value);
    return "'max_rate': " + rate.str();
  }
  const std::string name = parameterNameOf(option.name);
  const auto& known = nodes::encodingParameters();
  const auto found =
      std::find_if(known.begin(), known.end(), [&name](const auto& parameter) {
        return parameter.name == name;
      });
  if (found == known.end() || name == "resolution" || name == "effort")
    return {};
  const nodes::ParameterValue& type = found->default_value;
  if (std::holds_alternative<bool>(type))
    return '\'' + name + "': True";
  // A list as a text, as Python's lists of whole numbers have another type.
  const bool is_list = std::holds_alternative<std::vector<double>>(type);
  const bool is_text = is_list || std::holds_alternative<std::string>(type);
  return '\'' + name + "': " +
         (is_text ? nodes::textOf(is_list ? '[' + option.value + ']' : option.value)
                  : option.value);
}

/** \brief What a launch file of ROS 2 has for a choice. */
std::string
parametersOf(const std::vector<GivenOption>& given,
             const StreamTrials& trials,
             const std::string& edge,
             const std::string& effort)
{
  std::string text = "parameters=[{'resolution': " + edge + ", 'intensity': '" +
                     nameOf(trials.law) + "', 'effort': '" + effort + '\'';
  for (const GivenOption& option : given)
    if (const std::string parameter = parameterOf(option); !parameter.empty())
      text += ", " + parameter;
  return text + "}]";
}

/** \brief Why nothing keeps the limits; empty if the choice does. */
std::string
faultOf(const StreamTrials& trials, const std::string& rate_text)
{
  switch (trials.choice.fault) {
  case ChoiceFault::Rate:
    return "nothing here keeps within --max-rate " + rate_text +
           "; the mark is at the fewest bytes: --crop, --temporal-filter or fewer "
           "clouds take fewer";
  case ChoiceFault::Time:
    return "nothing here encodes a cloud in half of the " +
           formatted(1e3 * trials.limits.period, 0) +
           " ms from one to the next; the mark is at the fastest";
  case ChoiceFault::Holes:
    return std::string("no edge here has at most ") + most_holes +
           " holes, or there is no surface; the mark is at the largest";
  case ChoiceFault::None:
    break;
  }
  return {};
}

void
printStream(const HeldClouds& stream, const StreamTrials& trials)
{
  std::cout << printable(stream.name) << ": " << counted(stream.clouds.size(), "cloud")
            << " of " << formatted(trials.points, 0) << " points, "
            << formatted(1.0 / trials.limits.period, 1) << " a second";
  if (stream.has_assumed_period || stream.period <= 0.0)
    std::cout << ", assumed, as nothing tells (--rate)";
  std::cout << "; law " << nameOf(trials.law) << '\n';
  if (stream.clouds.size() == 1)
    std::cout << "One cloud does not tell what P-frames take, which is less: rates are "
                 "those of I-frames.\n";
  if (trials.edges.front().edge >= 1.0)
    std::cout << "Its points are metres apart: if they are in millimetres, so are the "
                 "edges.\n";
}

void
printLegend()
{
  std::cout
      << "*: the finest edge that keeps within --max-rate, for each stream, as rate "
         "control demands (each second; 95 % of it\nin the mean, and of its buffer by "
         "I-frames), with at most "
      << most_holes
      << " holes unless -r or\n--keep-points is given, and that some effort encodes in "
         "half of the time from one cloud to the next;\neffort balanced, or small "
         "where only that keeps the rate, or fast where balanced takes more time."
         "\nholes: share of the points on "
         "surfaces with an empty voxel beside theirs, along the surface; points are "
         "on\na "
         "surface if they have none at some larger edge. noise: share of points "
         "(lidars "
         "with rows) or voxels (others)\nthat --remove-outliers takes, with law count "
         "in "
         "place of native or none. kbit/s: by the stamps of the clouds,\nwith "
         "I-frames as --i-frame-rate and --i-frame-every say. ms: encoding a cloud on "
         "this machine, median.\n";
}

/** \brief Prints what there is to say of one stream.
 * \return whether the choice keeps the limits
 */
bool
advise(const AdviseOptions& options,
       const std::vector<HeldClouds>& streams,
       std::size_t number,
       Console& console)
{
  console.startProgress("trials", 0);
  const StreamTrials trials = tryStream(
      options.trials, streams[number], streams.size(), [&] { console.advance(); });
  console.endProgress();
  if (trials.edges.empty()) {
    if (!isInterrupted())
      console.error(streams[number].name + ": nothing can be told: " + trials.fault);
    return false;
  }
  printStream(streams[number], trials);
  printTable(trials);
  const std::string fault = faultOf(trials, options.rate_text);
  if (!fault.empty())
    console.error(streams[number].name + ": " + fault);
  const std::string& outside = trials.edges[trials.choice.edge].points_outside_grid;
  if (!outside.empty())
    console.error(outside);
  const std::string edge = textOf(trials.edges[trials.choice.edge].edge);
  const std::string effort = nameOf(io::efforts, trials.choice.effort);
  std::cout << "  " << printable(commandOf(options, streams, number, edge, effort))
            << "\n  " << printable(parametersOf(options.given, trials, edge, effort))
            << "\n\n";
  return fault.empty() && outside.empty();
}

int
advise(AdviseOptions& options)
{
  constexpr std::size_t clouds = 30; // the usual I-frame rate
  Console console("advise", options.is_quiet);
  const std::vector<HeldClouds> streams =
      holdTriedInput(options.input, options.trials.encoding, clouds, console);
  options.trials.encoding.check();
  bool is_complete = !streams.empty();
  for (std::size_t i = 0; i < streams.size() && !isInterrupted(); ++i) {
    is_complete &= streams[i].failures.empty() && !streams[i].clouds.empty();
    if (!streams[i].clouds.empty())
      is_complete &= advise(options, streams, i, console);
  }
  if (!isInterrupted())
    printLegend();
  return isInterrupted() ? interrupted : is_complete ? all_done : something_failed;
}

} // namespace

Run
addAdvise(CLI::App& app)
{
  const auto options = std::make_shared<AdviseOptions>();
  TrialOptions& trials = options->trials;
  addTriedInput(app, options->input);
  addParsed(app,
            "--max-rate",
            "RATE",
            "of each stream, such as 500kbit/s or 2Mbit/s",
            [options](const std::string& text) {
              if (const double rate = parseRate(text); rate > 0.0)
                options->trials.max_rate = rate; // as with encode, 0 is no limit
              options->rate_text = text;
            });
  trials.encoding.addCodecOptions(app);
  app.remove_option(app.get_option("--format")); // there are no edges to choose from
  app.get_option("--resolution")
      ->description("the only edge of a voxel to try, metres");
  app.get_option("--effort")->description("the only effort to try");
  trials.encoding.addCloudOptions(app);
  addQuiet(app, options->is_quiet);
  return [options, &app, &trials] {
    if (options->input.input.inputs.empty() && !options->input.takes_cell)
      throw UsageError("name clouds or a bag, or --cell");
    if (isGiven(app, "--resolution"))
      trials.edge = trials.encoding.codec().resolution;
    if (isGiven(app, "--effort"))
      trials.effort = trials.encoding.codec().effort;
    options->given = givenOptions(app);
    completeTriedInput(app, options->input, trials.encoding);
    trials.usual_period = 1.0 / options->input.input.rate;
    return advise(*options);
  };
}

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/tried_input.h"

#include "clouds/cloud_sequence.h"
#include "console/interruption.h"
#include "options/bin_options.h"
#include "options/options.h"
#include "simulator/robot_cell.h"

#include <algorithm>
#include <memory>

namespace pcl_ext::tools {

namespace {

/** \brief The clouds of sensor 1 of the robot cell. */
std::vector<HeldClouds>
holdCell(EncodingOptions& options, std::size_t clouds, Console& console)
{
  constexpr std::size_t most_clouds = 60; // 210 MB
  options.completeForCell();
  const std::size_t count = std::min(clouds, most_clouds);
  const auto sequence = clouds::openCell(1, count, 1);
  std::vector<HeldClouds> streams(1);
  streams[0].name = "/" + sequence->name();
  streams[0].period = 1.0 / cell::RobotCell::frame_rate;
  options.setPose(streams[0].name, WorldPose(sequence->sensorPose()));
  console.startProgress("clouds of the cell", count);
  for (std::size_t i = 0; i < count && !isInterrupted(); ++i) {
    sequence->read(i, streams[0].clouds.emplace_back());
    console.advance();
  }
  console.endProgress();
  return streams;
}

} // namespace

void
addTriedInput(CLI::App& app, TriedInput& tried, const std::string& description)
{
  app.add_option("IN", tried.input.inputs, description)->type_name("");
  app.add_flag("--cell",
               tried.takes_cell,
               "the simulated robot cell, at 0.04 m and with law count");
  addNumber(app,
            "--rate",
            tried.input.rate,
            1e-6,
            1e6,
            "HZ",
            "clouds per second, of files; times in names are left out");
  addBinFields(app, tried.input.bin_fields);
  addNames(app, "--topics", tried.input.topics, "only these clouds of a bag");
}

void
completeTriedInput(const CLI::App& app, TriedInput& tried, EncodingOptions& options)
{
  if (tried.takes_cell && !tried.input.inputs.empty())
    throw UsageError("--cell is an input itself: leave it or the others out");
  tried.input.has_rate = isGiven(app, "--rate");
  tried.input.long_integers = options.longIntegers();
  tried.takes_cell = tried.input.inputs.empty();
  if (!tried.takes_cell)
    return;
  refuseOptions(app,
                {"--rate", "--bin-fields", "--topics", "--pose"},
                "is for inputs: leave it out, or name one");
  options.setDefaults(isGiven(app, "--resolution") ? options.codec().resolution
                                                   : cell_resolution,
                      options.law().value_or(cell_law));
}

std::vector<HeldClouds>
holdTriedInput(const TriedInput& tried,
               EncodingOptions& options,
               std::size_t clouds,
               Console& console)
{
  if (tried.takes_cell)
    return holdCell(options, clouds, console);
  const std::unique_ptr<CloudInput> input = openInput(tried.input);
  for (const std::string& remark : input->remarks())
    console.remark(remark);
  std::vector<HeldClouds> streams = holdClouds(*input, clouds);
  for (const std::string& remark : input->remarksOnClouds())
    console.remark(remark);
  options.checkStreams(input->streams());
  for (const HeldClouds& stream : streams) {
    for (const std::string& failure : stream.failures)
      console.error(failure);
    if (stream.clouds.empty())
      console.error(stream.name + ": it has no cloud that can be read");
  }
  for (const std::string& place : input->damage())
    console.error(place);
  return streams;
}

std::string
quoted(const std::string& word)
{
  constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                "0123456789_-+=:,./@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos)
    return word;
  std::string text = "'";
  for (const char letter : word)
    text += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  return text + '\'';
}

std::string
GivenOption::text() const
{
  return value.empty() ? name : name + (is_flag ? '=' : ' ') + quoted(value);
}

std::vector<GivenOption>
givenOptions(const CLI::App& app)
{
  std::vector<GivenOption> given;
  for (const CLI::Option* const option : app.get_options()) {
    if (option->count() == 0 || option->get_positional())
      continue;
    const bool is_flag = option->get_items_expected_max() == 0;
    for (const std::string& value : option->results())
      given.push_back({option->get_name(),
                       is_flag && value == "true" ? std::string() : value,
                       is_flag});
  }
  return given;
}

} // namespace pcl_ext::tools

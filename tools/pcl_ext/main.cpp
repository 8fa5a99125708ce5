// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The program pcl_ext: recordings of compressed clouds, on the command line.
 */
#include <pcl_ext/version.h>

#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "console/terminal.h"
#include "options/help_format.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <exception>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext::tools {

// In place of the commands that the program was built without.

#if !defined(PCL_EXT_HAS_VIEW) || !defined(PCL_EXT_HAS_SITE)
/** \brief Takes any options, and fails.
 * \param[in] needed what was not found when the program was built
 */
static Run
addUnbuilt(CLI::App& app, const char* needed)
{
  app.allow_extras();
  return [needed]() -> int {
    throw std::runtime_error("this program was built without " + std::string(needed));
  };
}
#endif

#ifndef PCL_EXT_HAS_VIEW
Run
addView(CLI::App& app)
{
  return addUnbuilt(app, "Boost.Beast, which the viewer's server needs");
}
#endif

#ifndef PCL_EXT_HAS_SITE
constexpr const char* site_needs =
    "libnats, Boost.Beast or OctoMap, which the commands of a site need";

Run
addSend(CLI::App& app)
{
  return addUnbuilt(app, site_needs);
}

Run
addReceive(CLI::App& app)
{
  return addUnbuilt(app, site_needs);
}

Run
addKeep(CLI::App& app)
{
  return addUnbuilt(app, site_needs);
}
#endif

} // namespace pcl_ext::tools

namespace {

using namespace pcl_ext::tools;

struct Command {
  CLI::App* app;
  Run run;
};

/** \brief Lets the process keep the memory of a cloud for the next one. Given back and
 * taken again, its pages are cleared by the system each time, which is a third of the
 * time of reading a folder. */
void
keepFreedMemory()
{
#ifdef __GLIBC__
  constexpr int largest_block = 32 << 20; // larger ones are given back at once
  constexpr int most_kept = 256 << 20;
  mallopt(M_MMAP_THRESHOLD, largest_block);
  mallopt(M_TRIM_THRESHOLD, most_kept);
#endif
}

std::vector<Command>
addCommands(CLI::App& program)
{
  std::vector<Command> commands;
  const auto add = [&](const char* name, const char* text, Run (*addTo)(CLI::App&)) {
    CLI::App* const app = program.add_subcommand(name, text);
    commands.push_back({app, addTo(*app)});
  };
  add("encode", "Encode clouds of files or a bag into a recording", addEncode);
  add("decode",
      "Decode a recording into PCD or PLY files, or a bag of clouds",
      addDecode);
  add("info", "Print what is in a recording, without decoding it", addInfo);
  add("verify", "Decode all frames of a recording, and tell which are lost", addVerify);
  add("cut", "Copy a part of a recording, by time, frames and streams", addCut);
  add("merge", "Put the streams of several recordings into one", addMerge);
  add("view", "Look at a recording or a live stream in a browser", addView);
  add("send", "Send streams to a site, over a NATS server", addSend);
  add("receive", "Record, show, merge or map the streams of a site", addReceive);
  add("keep", "Make the NATS server keep the frames of a site, for a replay", addKeep);
  add("advise", "Tell which voxel edge and effort suit clouds", addAdvise);
  add("benchmark", "Measure how long frames take on this machine", addBenchmark);
  add("demo", "Take clouds of a simulated robot cell through all of it", addDemo);
  return commands;
}

int
run(CLI::App& program, const std::vector<Command>& commands)
{
  for (const Command& command : commands) {
    if (!command.app->parsed())
      continue;
    const std::string name = "pcl_ext " + command.app->get_name();
    try {
      return command.run();
    }
    catch (const UsageError& error) {
      printError(name, error.what());
      return wrong_command_line;
    }
    catch (const std::exception& error) {
      printError(name, error.what());
      return isInterrupted() ? interrupted : something_failed;
    }
  }
  std::cout << program.help();
  return wrong_command_line;
}

/** \brief The name of the command that was given, for messages. */
std::string
nameOfCommand(const std::vector<Command>& commands)
{
  for (const Command& command : commands)
    if (command.app->parsed())
      return "pcl_ext " + command.app->get_name();
  return "pcl_ext";
}

/** \brief What to say of a first word that is no command; empty if it is one, or an
 * option. */
std::string
unknownCommand(const CLI::App& program, int argc, char** argv)
{
  const std::string word = argc > 1 ? argv[1] : "";
  if (word.empty() || word.front() == '-')
    return {};
  std::string known;
  for (const CLI::App* const command :
       program.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == word)
      return {};
    known += (known.empty() ? "" : ", ") + command->get_name();
  }
  return "there is no command '" + word + "'; there are " + known;
}

/** \brief Names the words that no command takes, without the -- before names of files. */
std::string
unexpectedWords(const CLI::App& program)
{
  std::string words;
  for (const std::string& word : program.remaining(true))
    if (word != "--")
      words += (words.empty() ? "" : ", ") + word;
  return "not expected: " + words;
}

/** \brief Completes the standard output.
 * \return the status, or something_failed if it took not all of it
 */
int
finishOutput(const std::string& name, int status)
{
  std::cout.flush();
  if (std::cout)
    return status;
  // A reader that has enough, as head, is no failure to tell of.
  if (!isReaderGone())
    std::cerr << name << ": cannot write to the standard output\n";
  return status == all_done ? something_failed : status;
}

} // namespace

int
main(int argc, char** argv)
{
  keepFreedMemory();
  CLI::App program(
      "Compresses streams of point clouds into voxels with intensity, and back.",
      "pcl_ext");
  program.formatter(std::make_shared<HelpFormat>());
  program.footer("Exit status: 0 done; 1 something lost, damaged or failed; 2 wrong "
                 "command line; 130 interrupted");
  program.set_version_flag(
      "--version", pcl_ext::version(), "print the version and exit");
  program.set_help_flag("-h,--help", "print this and exit");
  program.require_subcommand(0, 1);
  program.get_formatter()->label("SUBCOMMAND", "COMMAND");
  const std::vector<Command> commands = addCommands(program);
  try {
    program.parse(argc, argv);
  }
  catch (const CLI::Success& asked) { // --help or --version
    return finishOutput("pcl_ext", program.exit(asked));
  }
  catch (const CLI::ExtrasError&) {
    const std::string command = unknownCommand(program, argc, argv);
    printError(nameOfCommand(commands),
               command.empty() ? unexpectedWords(program) + "; see " +
                                     nameOfCommand(commands) + " --help"
                               : command);
    return wrong_command_line;
  }
  catch (const std::exception& error) {
    printError(nameOfCommand(commands),
               std::string(error.what()) + "; see " + nameOfCommand(commands) +
                   " --help");
    return wrong_command_line;
  }
  catchInterruptions();
  return finishOutput(nameOfCommand(commands), run(program, commands));
}

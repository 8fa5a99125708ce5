// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * cloudini, by its own program, as it is no package.
 */
#include "coders/stream_coder.h"

#include <pcl/io/pcd_io.h>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Runs a program without its output. Returns true if it succeeded. */
bool
runQuietly(std::vector<std::string> arguments)
{
  std::vector<char*> argv;
  for (std::string& argument : arguments)
    argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", 1, 0);
  pid_t process = -1;
  int status = -1;
  const bool is_started =
      posix_spawnp(&process, argv[0], &actions, nullptr, argv.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  return is_started && waitpid(process, &status, 0) == process && status == 0;
}

class CloudiniCoder : public StreamCoder {
public:
  CloudiniCoder(const Workload& workload, std::string program)
  : StreamCoder("cloudini", Content::Points)
  , program_(std::move(program))
  , edge_(workload.resolution)
  {}

  /** \brief Encodes, untimed: starting a program and reading its file would count. */
  void
  prepare(const InputFrame& frame) override
  {
    const auto folder = std::filesystem::temp_directory_path();
    const std::string name = "pcl_ext_benchmark_" + std::to_string(getpid());
    const auto input = folder / (name + ".pcd");
    const auto output = folder / (name + ".cldn");
    pcl::io::savePCDFileBinary(input.string(), *frame.positions);
    const bool is_done = runQuietly({program_,
                                     "-y",
                                     "-f",
                                     input.string(),
                                     "-o",
                                     output.string(),
                                     "-r",
                                     std::to_string(edge_)});
    std::filesystem::remove(input);
    if (!is_done)
      throw std::runtime_error("'" + program_ + "' failed");
    frame_bytes_ = static_cast<std::size_t>(std::filesystem::file_size(output));
    std::filesystem::remove(output);
  }

  void
  encode(const InputFrame& /* frame */) override
  {}

  void
  decode() override
  {}

  void
  check(const InputFrame& /* frame */) override
  {}

private:
  std::string program_;
  double edge_;
};

} // namespace

void
addCloudiniCoder(const Workload& workload,
                 const std::string& program,
                 StreamCoders& coders)
{
  if (!program.empty())
    coders.push_back(std::make_unique<CloudiniCoder>(workload, program));
}

} // namespace measuring
} // namespace pcl_ext

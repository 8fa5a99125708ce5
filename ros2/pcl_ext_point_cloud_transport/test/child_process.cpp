// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "child_process.h"

#include "plugin_test.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

namespace pcl_ext_point_cloud_transport::test {

namespace {

std::string
newOutputFile()
{
  static int number = 0;
  return temporaryPath("output_" + std::to_string(number++) + ".txt");
}

/** \brief The child between fork and exec, where few functions are allowed. */
[[noreturn]] void
becomeProgram(const char* output_file, char* const* arguments)
{
  ::prctl(PR_SET_PDEATHSIG, SIGKILL); // ends with a test that crashes
  const int input = ::open("/dev/null", O_RDONLY);
  const int output = ::open(output_file, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(input, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  ::execvp(arguments[0], arguments);
  ::_exit(127);
}

} // namespace

ChildProcess::ChildProcess(std::vector<std::string> command)
: output_file_(newOutputFile())
{
  std::vector<char*> arguments;
  for (std::string& text : command)
    arguments.push_back(text.data());
  arguments.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ == 0)
    becomeProgram(output_file_.c_str(), arguments.data());
  EXPECT_GT(pid_, 0) << "fork failed";
}

ChildProcess::~ChildProcess()
{
  if (interrupt(20.0) || pid_ <= 0)
    return;
  ADD_FAILURE() << "The program does not end:\n" << output();
  ::kill(pid_, SIGKILL);
  waitForExit();
}

std::optional<int>
ChildProcess::waitForExit(double seconds)
{
  waitFor([this] { return !isRunning(); }, seconds);
  return exit_code_;
}

std::optional<int>
ChildProcess::interrupt(double seconds)
{
  if (isRunning())
    ::kill(pid_, SIGINT);
  return waitForExit(seconds);
}

bool
ChildProcess::isRunning()
{
  int state = 0;
  if (exit_code_ || pid_ <= 0 || ::waitpid(pid_, &state, WNOHANG) != pid_)
    return !exit_code_ && pid_ > 0;
  exit_code_ = WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
  return false;
}

std::string
ChildProcess::output() const
{
  std::ostringstream text;
  text << std::ifstream(output_file_).rdbuf();
  return text.str();
}

} // namespace pcl_ext_point_cloud_transport::test

#include "tools/view_process.h"

#include "tools/program.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>

namespace pcl_ext {
namespace tools {
namespace test {

ViewProcess::ViewProcess(const TestFolder& folder,
                         const std::string& arguments,
                         const std::string& environment)
: errors_file_(folder / ".view_errors")
{
  writeBytes(folder / "page.html",
             Bytes(view_page, view_page + std::strlen(view_page)));
  const std::string command = "cd '" + folder / "" + "' && exec env " + environment +
                              " '" + testedProgram() + "' view --page page.html " +
                              arguments + " 2> '" + errors_file_ + "'";
  int to_program[2];
  int from_program[2];
  EXPECT_EQ(::pipe2(to_program, O_CLOEXEC), 0);
  EXPECT_EQ(::pipe2(from_program, O_CLOEXEC), 0);
  pid_ = ::fork();
  if (pid_ == 0) {
    ::dup2(to_program[0], STDIN_FILENO);
    ::dup2(from_program[1], STDOUT_FILENO);
    ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::close(to_program[0]);
  ::close(from_program[1]);
  input_ = to_program[1];
  for (char letter = 0; letter != '\n' && ::read(from_program[0], &letter, 1) == 1;)
    line_ += letter;
  ::close(from_program[0]);
  const std::size_t end = line_.rfind("/ (");
  const std::size_t colon = line_.rfind(':', end);
  EXPECT_NE(end, std::string::npos) << line_ << errors();
  if (end != std::string::npos)
    port_ = static_cast<std::uint16_t>(std::stoi(line_.substr(colon + 1)));
}

ViewProcess::~ViewProcess()
{
  closeInput();
  if (pid_ > 0)
    waitForEnd(SIGKILL);
}

void
ViewProcess::write(const Bytes& bytes)
{
  EXPECT_EQ(::write(input_, bytes.data(), bytes.size()),
            static_cast<ssize_t>(bytes.size()));
}

void
ViewProcess::closeInput()
{
  if (input_ >= 0)
    ::close(input_);
  input_ = -1;
}

int
ViewProcess::waitForEnd(int signal)
{
  if (signal != 0)
    ::kill(pid_, signal);
  int result = 0;
  EXPECT_EQ(::waitpid(pid_, &result, 0), pid_);
  pid_ = -1;
  return WIFEXITED(result) ? WEXITSTATUS(result) : -1;
}

std::string
ViewProcess::errors() const
{
  const Bytes bytes = bytesOf(errors_file_);
  return {bytes.begin(), bytes.end()};
}

} // namespace test
} // namespace tools
} // namespace pcl_ext

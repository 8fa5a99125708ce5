// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "tools/program.h"
#include "view/live_source.h"

#include <gtest/gtest.h>

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>

namespace pcl_ext::tools::test {

/** \brief A run of the program that goes on until it ends or is told to. */
class BackgroundProgram {
public:
  /** \param[in] folder working folder
   * \param[in] line of a shell that executes the program, $P
   */
  BackgroundProgram(const TestFolder& folder, const std::string& line)
  {
    static int runs = 0;
    output_ = folder / (".output_" + std::to_string(++runs));
    errors_ = folder / (".errors_" + std::to_string(runs));
    writeBytes(errors_, {});
    const std::string command = "cd '" + folder / "" + "' && P='" + testedProgram() +
                                "' && { " + line + "; } > '" + output_ + "' 2> '" +
                                errors_ + "'";
    pid_ = ::fork();
    if (pid_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
  }

  ~BackgroundProgram()
  {
    if (pid_ > 0)
      end(SIGKILL);
  }

  BackgroundProgram(const BackgroundProgram&) = delete;
  BackgroundProgram&
  operator=(const BackgroundProgram&) = delete;

  void
  waitForError(const std::string& text) const
  {
    EXPECT_TRUE(view::test::waitFor([&] { return hasPart(errors(), text); }))
        << text << " is not in: " << errors();
  }

  void
  waitForOutput(const std::string& text) const
  {
    EXPECT_TRUE(view::test::waitFor([&] { return hasPart(output(), text); }))
        << text << " is not in: " << output() << errors();
  }

  /** \brief Waits for its end.
   * \param[in] signal that it is sent before; 0: none
   * \return its exit status; -1 if a signal ended it
   */
  int
  end(int signal)
  {
    if (signal != 0)
      ::kill(pid_, signal);
    int result = 0;
    EXPECT_EQ(::waitpid(pid_, &result, 0), pid_);
    pid_ = -1;
    return WIFEXITED(result) ? WEXITSTATUS(result) : -1;
  }

  std::string
  output() const
  {
    return textOf(output_);
  }

  std::string
  errors() const
  {
    return textOf(errors_);
  }

private:
  std::string output_;
  std::string errors_;
  pid_t pid_ = -1;
};

} // namespace pcl_ext::tools::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Programs that a test starts, observes and stops.
 */
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace pcl_ext_point_cloud_transport::test {

/** \brief A running program. It ends with this object at the latest. */
class ChildProcess {
public:
  /** \brief Starts a program.
   * \param[in] command the program, searched in PATH if it has no slash, and its
   * arguments
   */
  explicit ChildProcess(std::vector<std::string> command);

  /** \brief Interrupts the program, then kills it if it does not end. */
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess&
  operator=(const ChildProcess&) = delete;

  /** \brief Waits for the end of the program.
   * \return exit code, or -signal if a signal ended it; nothing if it still runs
   */
  std::optional<int>
  waitForExit(double seconds = 60.0);

  /** \brief Sends SIGINT, as Ctrl-C does, and waits. */
  std::optional<int>
  interrupt(double seconds = 60.0);

  bool
  isRunning();

  /** \brief Its output until now, stdout and stderr together. */
  std::string
  output() const;

private:
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
  std::string output_file_;
};

} // namespace pcl_ext_point_cloud_transport::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

/** \brief Prints one line on standard error: an error or a remark.
 * \param[in] command whose it is, such as "pcl_ext encode"
 * \param[in] message may name files and streams by any bytes, and settings by their
 * fields
 */
void
printError(const std::string& command, const std::string& message);

/** \brief What a command prints while it works: errors, remarks, and how far it is.
 *
 * Progress goes to standard error: on a terminal a bar with rate and remaining time,
 * else lines, the first after ten seconds and each after twice the time of the one
 * before.
 */
class Console {
public:
  /** \param[in] command such as "encode", for messages
   * \param[in] is_quiet progress and remarks are left out
   */
  Console(const std::string& command, bool is_quiet);

  /** \brief Progress is for programs: lines of JSON on standard error, also if quiet. The
   * first is that of the start, the last that of the end; at most ten a second between.
   * */
  void
  reportProgress()
  {
    is_progress_json_ = true;
  }

  /** \brief Standard output takes frames: summaries go to standard error. */
  void
  keepOutputFree();

  /** \brief Keeps errors and remarks for takeLines() instead of printing them, and leaves
   * progress and summaries out. */
  void
  holdLines()
  {
    holds_lines_ = true;
  }

  /** \brief The lines that were kept, in their order. */
  std::vector<std::string>
  takeLines()
  {
    return std::move(lines_);
  }

  /** \brief All errors until now. */
  const std::vector<std::string>&
  errors() const
  {
    return errors_;
  }

  /** \brief Prints one line with the name of the command on standard error. */
  void
  error(const std::string& message);

  /** \brief The same, but not if quiet. */
  void
  remark(const std::string& message);

  /** \brief Prints a line on standard output: what was done. */
  void
  summary(const std::string& line);

  /** \brief Starts counting anew.
   * \param[in] what is counted, such as "frames"
   * \param[in] total number of them; 0: unknown
   */
  void
  startProgress(const std::string& what, std::size_t total);

  /** \brief One more is done. */
  void
  advance(std::size_t count = 1);

  /** \brief Removes the bar, or the line of status(). */
  void
  endProgress();

  /** \brief True if status() shows what it is given: on a terminal, unless quiet. */
  bool
  showsStatus() const
  {
    return is_terminal_ && !is_quiet_ && !holds_lines_;
  }

  /** \brief Shows a line in place of the last such line. */
  void
  status(const std::string& line);

private:
  using Clock = std::chrono::steady_clock;

  void
  show(Clock::time_point now);

  void
  showJson();

  /** \brief Replaces the line of the bar on the terminal. */
  void
  showLine(const std::string& line);

  /** \brief Characters that fit on a line of the terminal. */
  static std::size_t
  lineWidth();

  void
  printLine(const std::string& message);

  std::string name_;
  const bool is_quiet_;
  bool is_progress_json_ = false;
  bool is_output_free_ = false;
  bool holds_lines_ = false;
  std::vector<std::string> lines_;  // that are held
  std::vector<std::string> errors_; // of all lines
  bool is_terminal_;
  std::string what_;
  std::size_t total_ = 0;
  std::size_t done_ = 0;
  std::size_t shown_ = 0; // as JSON
  bool is_bar_shown_ = false;
  Clock::time_point start_;
  Clock::time_point next_;
  Clock::duration until_next_{};
};

} // namespace pcl_ext::tools

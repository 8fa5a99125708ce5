// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "console/console.h"

#include "console/printable_text.h"
#include "console/terminal.h"
#include "inputs/standard_input.h"
#include "measuring/markdown_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

namespace pcl_ext::tools {

namespace {

using measuring::formatted;

constexpr std::chrono::milliseconds first_bar_after{1000};
constexpr std::chrono::milliseconds bar_period{100};
constexpr std::chrono::milliseconds first_line_after{10000};

/** \brief 1:05 or 1:02:05. */
std::string
minutesAndSeconds(double seconds)
{
  const auto whole = static_cast<long>(std::ceil(seconds));
  char text[40];
  if (whole >= 3600)
    std::snprintf(text,
                  sizeof(text),
                  "%ld:%02ld:%02ld",
                  whole / 3600,
                  whole / 60 % 60,
                  whole % 60);
  else
    std::snprintf(text, sizeof(text), "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

std::string
bar(std::size_t done, std::size_t total)
{
  constexpr std::size_t width = 30;
  const std::size_t full = width * std::min(done, total) / total;
  return "[" + std::string(full, '#') + std::string(width - full, ' ') + "] ";
}

} // namespace

void
printError(const std::string& command, const std::string& message)
{
  std::cerr << command << ": " << printable(shown(message)) << std::endl;
}

Console::Console(const std::string& command, bool is_quiet)
: name_("pcl_ext " + command)
, is_quiet_(is_quiet)
, is_terminal_(isTerminal(StandardStream::Error))
{}

void
Console::keepOutputFree()
{
  is_output_free_ = true;
}

void
Console::error(const std::string& message)
{
  errors_.push_back(message);
  printLine(message);
}

void
Console::remark(const std::string& message)
{
  if (!is_quiet_)
    printLine(message);
}

void
Console::printLine(const std::string& message)
{
  if (holds_lines_) {
    lines_.push_back(message);
    return;
  }
  endProgress();
  std::cout.flush();
  printError(name_, message);
}

void
Console::summary(const std::string& line)
{
  if (holds_lines_)
    return;
  endProgress();
  (is_output_free_ ? std::cerr : std::cout) << printable(line) << std::endl;
}

void
Console::startProgress(const std::string& what, std::size_t total)
{
  endProgress();
  what_ = what;
  total_ = total;
  done_ = 0;
  start_ = Clock::now();
  until_next_ = first_line_after;
  next_ = start_ + (is_terminal_ ? first_bar_after : first_line_after);
  if (is_progress_json_)
    showJson();
}

void
Console::advance(std::size_t count)
{
  done_ += count;
  if ((is_quiet_ && !is_progress_json_) || holds_lines_)
    return;
  const Clock::time_point now = Clock::now();
  if (now < next_)
    return;
  if (is_progress_json_)
    return showJson();
  next_ = now + (is_terminal_ ? bar_period : until_next_);
  until_next_ *= 2;
  show(now);
}

void
Console::show(Clock::time_point now)
{
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate = static_cast<double>(done_) / seconds;
  std::string text = formatted(static_cast<double>(done_), 0);
  if (total_ > 0)
    text += " of " + formatted(static_cast<double>(total_), 0);
  text += " " + what_ + ", " + formatted(rate, rate < 10.0 ? 1 : 0) + " a second";
  if (total_ > done_ && rate > 0.0)
    text +=
        ", " + minutesAndSeconds(static_cast<double>(total_ - done_) / rate) + " left";
  if (!is_terminal_) {
    std::cerr << name_ << ": " << text << std::endl;
    return;
  }
  const std::string bar_before = total_ > 0 ? bar(done_, total_) : "";
  if (bar_before.size() + text.size() <= lineWidth())
    text = bar_before + text;
  showLine(text);
}

/** \brief Prints how far it is, for programs. */
void
Console::showJson()
{
  shown_ = done_;
  next_ = Clock::now() + bar_period;
  const std::string total = total_ > 0 ? std::to_string(total_) : "null";
  std::cerr << "{\"done\": " << done_ << ", \"total\": " << total << ", \"of\": \""
            << what_ << "\"}" << std::endl;
}

std::size_t
Console::lineWidth()
{
  // A line that the terminal breaks could not be overwritten.
  constexpr std::size_t usual = 80;
  const std::size_t columns = terminalWidth();
  return (columns > 1 ? columns : usual) - 1;
}

void
Console::showLine(const std::string& line)
{
  // Back to the first column, and clear to the end of the line.
  std::cerr << '\r' << line.substr(0, lineWidth()) << "\x1b[K" << std::flush;
  is_bar_shown_ = true;
}

void
Console::status(const std::string& line)
{
  if (showsStatus())
    showLine(printable(line));
}

void
Console::endProgress()
{
  if (is_bar_shown_)
    std::cerr << "\r\x1b[K" << std::flush;
  is_bar_shown_ = false;
  if (is_progress_json_ && shown_ != done_)
    showJson();
}

} // namespace pcl_ext::tools

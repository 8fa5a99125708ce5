// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "console/console.h"
#include "measuring/markdown_table.h"

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

namespace pcl_ext::tools {

/** \brief What a command that runs until it is interrupted has done so far. */
struct LiveFigures {
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0; ///< of these
  bool is_connected = true;
  std::optional<std::chrono::nanoseconds> age; ///< of the stream that waits the longest
  std::string rest; ///< such as ", 2 lost"; empty if there is nothing to tell
};

/** \brief The state of a command that sends or receives, as one line on a terminal that
 * is replaced twice a second. Elsewhere nothing is printed. */
class StatusLine {
public:
  explicit StatusLine(Console& console) : console_(console) {}

  /** \brief Shows the line, if that is due.
   * \param[in] figures returns those of now
   */
  void
  update(const std::function<LiveFigures()>& figures)
  {
    const Clock::time_point now = Clock::now();
    if (!console_.showsStatus() || now < next_)
      return;
    next_ = now + period;
    const LiveFigures shown = figures();
    past_.push_back({now, shown.frames, shown.bytes});
    while (past_.size() > 2 && now - past_[1].time >= window)
      past_.pop_front();
    console_.status(textOf(shown));
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds period{500};
  static constexpr std::chrono::seconds window{2}; // of the rates

  struct Past {
    Clock::time_point time;
    std::uint64_t frames;
    std::uint64_t bytes;
  };

  std::string
  textOf(const LiveFigures& figures) const
  {
    using measuring::formatted;
    constexpr double kilobyte = 1e3;
    const double seconds =
        std::chrono::duration<double>(past_.back().time - past_.front().time).count();
    const auto rate = [&](std::uint64_t now, std::uint64_t before) {
      return seconds > 0.0 ? static_cast<double>(now - before) / seconds : 0.0;
    };
    std::string text = figures.is_connected ? "" : "NO CONNECTION, ";
    text += std::to_string(figures.frames) + " frames, " +
            formatted(rate(figures.frames, past_.front().frames), 1) + " a second, " +
            formatted(rate(figures.bytes, past_.front().bytes) / kilobyte, 1) + " kB/s";
    if (figures.age)
      text += ", oldest " +
              formatted(std::chrono::duration<double>(*figures.age).count(), 1) + " s";
    return text + figures.rest;
  }

  Console& console_;
  Clock::time_point next_ = Clock::now() + period;
  std::deque<Past> past_; // within the window, and the last one before it
};

} // namespace pcl_ext::tools

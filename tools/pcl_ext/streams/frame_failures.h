// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

/** \brief Reason of a frame that does not continue those before it. */
constexpr char undecodable_frame[] =
    "left out, as a frame before it is missing or it is damaged";

/** \brief Prints failures of frames. Of those of a stream that are alike it prints the
 * first one, and at the end how many more there were: thousands of lines hide the
 * others. */
class FrameFailures {
public:
  /** \param[in] print takes a line */
  explicit FrameFailures(std::function<void(const std::string&)> print)
  : print_(std::move(print))
  {}

  /** \brief Notes a failure.
   * \param[in] stream its name
   * \param[in] number of the frame
   * \param[in] place after the number, such as " at byte 7"; may be empty
   * \param[in] reason failures are alike if their reasons differ in numbers alone
   */
  void
  add(const std::string& stream,
      std::size_t number,
      const std::string& place,
      const std::string& reason);

  /** \brief Prints a line for each kind of which there was more than one. */
  void
  finish();

private:
  struct Kind {
    std::string stream;
    std::size_t first = 0; // frame that was printed
    std::size_t more = 0;
    std::size_t begin = 0; // frames of the others
    std::size_t end = 0;
  };

  std::function<void(const std::string&)> print_;
  std::vector<Kind> kinds_; // in the order of their first failures
  std::map<std::pair<std::string, std::string>, std::size_t> kind_of_; // in kinds_
};

} // namespace pcl_ext::tools

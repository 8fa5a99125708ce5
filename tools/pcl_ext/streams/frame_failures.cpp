// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "streams/frame_failures.h"

#include "options/text_values.h"

#include <algorithm>
#include <cctype>

namespace pcl_ext::tools {

namespace {

std::string
withoutNumbers(std::string text)
{
  text.erase(std::remove_if(text.begin(),
                            text.end(),
                            [](unsigned char letter) { return std::isdigit(letter); }),
             text.end());
  return text;
}

} // namespace

void
FrameFailures::add(const std::string& stream,
                   std::size_t number,
                   const std::string& place,
                   const std::string& reason)
{
  const auto [known, is_new] =
      kind_of_.try_emplace({stream, withoutNumbers(reason)}, kinds_.size());
  if (is_new) {
    kinds_.push_back({stream, number, 0, 0, 0});
    print_(stream + ", frame " + std::to_string(number) + place + ": " + reason);
    return;
  }
  Kind& kind = kinds_[known->second];
  kind.begin = kind.more == 0 ? number : std::min(kind.begin, number);
  kind.end = std::max(kind.end, number);
  ++kind.more;
}

void
FrameFailures::finish()
{
  for (const Kind& kind : kinds_)
    if (kind.more > 0)
      print_(kind.stream + ", frame" +
             (kind.more == 1 ? " " + std::to_string(kind.begin)
                             : "s " + std::to_string(kind.begin) + " to " +
                                   std::to_string(kind.end)) +
             ": " + counted(kind.more, "more failure") + " like that of frame " +
             std::to_string(kind.first));
  kinds_.clear();
  kind_of_.clear();
}

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_description.h>

#include "options/text_values.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief In what orders and sizes the scans of a stream are, as its I-frames tell. */
class PointOrders {
public:
  /** \brief Adds what a frame tells; nothing, if it is no I-frame of a scan. */
  void
  add(const io::FrameDescription& frame)
  {
    if (frame.is_i_frame && frame.has_points)
      add(inOrder(frame));
  }

  void
  add(const PointOrders& others)
  {
    for (const std::string& text : others.texts_)
      add(text);
    are_all_ &= others.are_all_;
  }

  bool
  empty() const
  {
    return texts_.empty();
  }

  /** \brief Whether all scans are in one order, and of one size. */
  bool
  areOne() const
  {
    return texts_.size() <= 1;
  }

  /** \brief As inOrder(), or several of it: "in order, 640 x 480, or in order, 320 x
   * 240". */
  std::string
  describe() const
  {
    std::string text;
    for (const std::string& order : texts_)
      text += (text.empty() ? "" : ", or ") + order;
    return text + (are_all_ ? "" : ", or others");
  }

private:
  static constexpr std::size_t most_texts = 3;

  void
  add(const std::string& text)
  {
    if (std::find(texts_.begin(), texts_.end(), text) != texts_.end())
      return;
    if (texts_.size() < most_texts)
      texts_.push_back(text);
    else
      are_all_ = false;
  }

  std::vector<std::string> texts_;
  bool are_all_ = true; // in texts_
};

} // namespace pcl_ext::tools

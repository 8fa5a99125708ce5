// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/fast/depth_residuals.h"

#include <algorithm>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

const std::vector<std::uint16_t>&
DepthResiduals::baseSymbolsOf(const VoxelFrame& frame)
{
  beginSplit(frame);
  work_.split.baseSymbolsOf(frame.intensities, work_.base_symbols);
  return work_.base_symbols;
}

void
DepthResiduals::encode(const VoxelFrame& frame,
                       bool is_i_frame,
                       std::vector<std::uint8_t>& payload)
{
  work_.split.predict(work_.base_symbols);
  collectClasses();
  work_.row.clear();
  for (std::size_t i = 0; i < work_.base_symbols.size(); ++i)
    if (work_.split.classes()[i] != DepthSplit::no_residual)
      work_.row.push_back(
          static_cast<std::uint16_t>(work_.split.residual(i, frame.intensities[i])));
  residuals_.encode(is_i_frame, work_.row, work_.row_classes, payload);
}

bool
DepthResiduals::decode(const std::uint8_t* begin,
                       const std::uint8_t* end,
                       bool is_i_frame,
                       VoxelFrame& frame)
{
  beginSplit(frame);
  work_.split.predict(frame.intensities);
  collectClasses();
  if (!residuals_.decode(begin, end, is_i_frame, work_.row_classes, work_.row))
    return false;
  std::size_t next = 0;
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (work_.split.classes()[i] != DepthSplit::no_residual &&
        !work_.split.symbol(i, work_.row[next++], frame.intensities[i]))
      return false;
  return true;
}

void
DepthResiduals::releaseMemory()
{
  residuals_.releaseMemory();
  work_ = Workspace();
}

void
DepthResiduals::beginSplit(const VoxelFrame& frame)
{
  work_.blocks.assign(frame.keys);
  // Without predictions, as the history has no depth offsets.
  work_.split.begin(
      *frame.depth_model, work_.blocks, {}, frame.intensity_scale.maxSymbol());
}

/** \brief Collects the classes of the residuals: the fraction of the prediction, and
 * the size of the symbol, of which most are large. */
void
DepthResiduals::collectClasses()
{
  work_.row_classes.clear();
  for (std::size_t i = 0; i < work_.split.classes().size(); ++i) {
    if (work_.split.classes()[i] == DepthSplit::no_residual)
      continue;
    const std::uint32_t size =
        std::clamp(work_.split.predictionContext(i) >> 4, 4u, 7u) - 4;
    work_.row_classes.push_back(static_cast<std::uint8_t>(
        size * 4 + (work_.split.predictionContext(i) >> 2 & 3)));
  }
}

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

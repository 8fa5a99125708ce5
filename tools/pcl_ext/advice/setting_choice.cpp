// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "advice/setting_choice.h"

namespace pcl_ext::tools {

namespace {

ChoiceFault
faultOf(const EdgeTrial& trial, const EffortTrial& effort, const ChoiceLimits& limits)
{
  if (limits.kilobits && effort.least_rate > *limits.kilobits)
    return ChoiceFault::Rate;
  if (effort.ms > 1e3 * ChoiceLimits::busy_share * limits.period)
    return ChoiceFault::Time;
  return trial.holes > limits.most_holes ? ChoiceFault::Holes : ChoiceFault::None;
}

/** \brief What is least in the best one of the choices with a fault. */
double
costOf(ChoiceFault fault, const EdgeTrial& trial, const EffortTrial& effort)
{
  switch (fault) {
  case ChoiceFault::Rate:
    return effort.kilobits;
  case ChoiceFault::Time:
    return effort.ms;
  case ChoiceFault::Holes:
    return -trial.edge;
  case ChoiceFault::None:
    break;
  }
  return trial.edge;
}

} // namespace

Choice
choose(const std::vector<EdgeTrial>& trials, const ChoiceLimits& limits)
{
  Choice best;
  std::optional<double> least;
  for (std::size_t edge = 0; edge < trials.size(); ++edge)
    for (const io::Effort effort :
         {io::Effort::Balanced, io::Effort::Small, io::Effort::Fast}) {
      const auto& trial = trials[edge].efforts[static_cast<std::size_t>(effort)];
      if (!trial)
        continue;
      const ChoiceFault fault = faultOf(trials[edge], *trial, limits);
      const double cost = costOf(fault, trials[edge], *trial);
      if (least && (fault > best.fault || (fault == best.fault && cost >= *least)))
        continue;
      best = {edge, effort, fault};
      least = cost;
    }
  return best;
}

} // namespace pcl_ext::tools

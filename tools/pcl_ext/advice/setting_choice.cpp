#include "advice/setting_choice.h"

#include <limits>

namespace pcl_ext {
namespace tools {

namespace {

ChoiceFault
faultOf(const EdgeTrial& trial, const EffortTrial& effort, const ChoiceLimits& limits)
{
  if (limits.kilobits && effort.kilobits > *limits.kilobits)
    return ChoiceFault::Rate;
  if (effort.ms > 1e3 * ChoiceLimits::busy_share * limits.period)
    return ChoiceFault::Time;
  return trial.holes > ChoiceLimits::most_holes ? ChoiceFault::Holes
                                                : ChoiceFault::None;
}

} // namespace

Choice
choose(const std::vector<EdgeTrial>& trials, const ChoiceLimits& limits)
{
  Choice least;
  double least_kilobits = std::numeric_limits<double>::infinity();
  for (std::size_t edge = 0; edge < trials.size(); ++edge)
    for (const io::Effort effort :
         {io::Effort::Balanced, io::Effort::Small, io::Effort::Fast}) {
      const auto& trial = trials[edge].efforts[static_cast<std::size_t>(effort)];
      if (!trial)
        continue;
      const Choice choice{edge, effort, faultOf(trials[edge], *trial, limits)};
      if (choice.fault == ChoiceFault::None)
        return choice;
      if (trial->kilobits < least_kilobits) {
        least = choice;
        least_kilobits = trial->kilobits;
      }
    }
  return least;
}

} // namespace tools
} // namespace pcl_ext

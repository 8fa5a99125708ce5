// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "measuring/machine.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Samples of one figure, such as one for each frame of a stream. All statistics
 * are 0 without samples. */
class Samples {
public:
  void
  add(double sample)
  {
    samples_.push_back(sample);
  }

  /** \brief Adds the sample of a frame. When a stream is repeated, the smallest one is
   * kept, as other load only makes times longer. */
  void
  keepLeast(std::size_t frame, double sample)
  {
    if (frame >= samples_.size())
      samples_.resize(frame + 1, std::numeric_limits<double>::infinity());
    samples_[frame] = std::min(samples_[frame], sample);
  }

  std::size_t
  count() const
  {
    return samples_.size();
  }

  double
  sum() const
  {
    return std::accumulate(samples_.begin(), samples_.end(), 0.0);
  }

  double
  mean() const
  {
    return samples_.empty() ? 0.0 : sum() / static_cast<double>(samples_.size());
  }

  /** \brief Standard deviation, of the population of all samples: 0 of a single one. */
  double
  deviation() const
  {
    const double middle = mean();
    double squares = 0.0;
    for (const double sample : samples_)
      squares += (sample - middle) * (sample - middle);
    return samples_.empty() ? 0.0
                            : std::sqrt(squares / static_cast<double>(samples_.size()));
  }

  double
  smallest() const
  {
    return samples_.empty() ? 0.0 : *std::min_element(samples_.begin(), samples_.end());
  }

  double
  largest() const
  {
    return samples_.empty() ? 0.0 : *std::max_element(samples_.begin(), samples_.end());
  }

  /** \brief The middle sample; of an even number the upper one. */
  double
  median() const
  {
    if (samples_.empty())
      return 0.0;
    std::vector<double> sorted = samples_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle;
  }

  /** \brief A percentile by the nearest rank: the smallest sample that so many of all do
   * not exceed.
   * \param[in] per_mille of the samples, 1 to 999: 500 for the median, 990, 999
   * \return none where it would be the largest one, for lack of samples: below 1000 /
   * (1000 - per_mille)
   */
  std::optional<double>
  percentile(std::size_t per_mille) const
  {
    const std::size_t rank = (per_mille * samples_.size() + 999) / 1000; // from 1
    if (rank == 0 || rank >= samples_.size())
      return std::nullopt;
    std::vector<double> sorted = samples_;
    const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(sorted.begin(), place, sorted.end());
    return *place;
  }

private:
  std::vector<double> samples_;
};

/** \brief Milliseconds of processor time of this thread that an action takes.
 *
 * Not wall-clock time: beside other programs that favours short actions, which end
 * before the scheduler gives the processor to another program.
 */
template <typename ActionT>
double
timeOf(ActionT&& action)
{
  const double start = threadCpuSeconds();
  action();
  return 1e3 * (threadCpuSeconds() - start);
}

/** \brief Milliseconds that pass while an action runs. */
template <typename ActionT>
double
wallTimeOf(ActionT&& action)
{
  const auto start = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() -
                                                   start)
      .count();
}

} // namespace measuring
} // namespace pcl_ext

#pragma once

#include <time.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief One figure of all frames of a stream. */
class Samples {
public:
  /** \brief Adds a frame's sample, or the least of several when the stream is repeated:
   * what else a machine does makes times longer, never shorter. */
  void
  keepLeast(std::size_t frame, double sample)
  {
    if (frame >= samples_.size())
      samples_.resize(frame + 1, std::numeric_limits<double>::infinity());
    samples_[frame] = std::min(samples_[frame], sample);
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

private:
  std::vector<double> samples_;
};

/** \brief Milliseconds of processor time that this thread has had.
 *
 * Not the clock on the wall: beside other programs it favours short actions, which end
 * before the system gives the processor to somebody else.
 */
inline double
processorTime()
{
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) +
         1e-6 * static_cast<double>(time.tv_nsec);
}

/** \brief Milliseconds of processor time that an action takes. */
template <typename ActionT>
double
timeOf(ActionT&& action)
{
  const double start = processorTime();
  action();
  return processorTime() - start;
}

} // namespace measuring
} // namespace pcl_ext

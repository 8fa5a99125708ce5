#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ext {
namespace measuring {

/** \brief Running mean, standard deviation and maximum (Welford's algorithm). */
class MeanAndDeviation {
public:
  void
  add(double sample)
  {
    ++count_;
    const double from_old_mean = sample - mean_;
    mean_ += from_old_mean / static_cast<double>(count_);
    squares_ += from_old_mean * (sample - mean_);
    largest_ = count_ == 1 ? sample : std::max(largest_, sample);
  }

  std::size_t
  count() const
  {
    return count_;
  }

  /** \brief 0 without samples. */
  double
  mean() const
  {
    return mean_;
  }

  /** \brief Of the population of all samples: 0 of a single one. */
  double
  deviation() const
  {
    return count_ == 0 ? 0.0 : std::sqrt(squares_ / static_cast<double>(count_));
  }

  /** \brief 0 without samples. */
  double
  largest() const
  {
    return largest_;
  }

private:
  std::size_t count_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0; ///< sum of the squared distances from the mean
  double largest_ = 0.0;
};

} // namespace measuring
} // namespace pcl_ext

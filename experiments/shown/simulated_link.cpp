// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulated_link.h"

#include <algorithm>
#include <random>

namespace pcl_ext {
namespace shown {

RateTrace
RateTrace::steady(const std::string& name, double bits_per_second)
{
  RateTrace trace;
  trace.name_ = name;
  trace.rates_ = {bits_per_second};
  return trace;
}

RateTrace
RateTrace::wireless(const std::string& name,
                    double bits_per_second,
                    double seconds,
                    std::uint32_t seed)
{
  RateTrace trace;
  trace.name_ = name;
  std::mt19937 random(seed); // the same numbers everywhere, distributions are not
  const auto uniform = [&random] {
    return static_cast<double>(random()) / 4294967296.0;
  };
  constexpr int steps_of_a_value = 5;
  constexpr double chance_of_a_drop = 0.03;
  constexpr double least_share = 0.1;
  constexpr double share_in_a_drop = 0.01;
  double share = 1.0;
  while (static_cast<double>(trace.rates_.size()) * step < seconds) {
    share = std::clamp(share + 0.5 * (uniform() - 0.5), least_share, 1.0);
    const bool drops = uniform() < chance_of_a_drop;
    const int steps = drops ? 4 + static_cast<int>(20.0 * uniform()) : steps_of_a_value;
    trace.rates_.insert(trace.rates_.end(),
                        static_cast<std::size_t>(steps),
                        bits_per_second * (drops ? share_in_a_drop : share));
  }
  return trace;
}

double
RateTrace::at(double time) const
{
  const auto number = static_cast<std::size_t>(std::max(time, 0.0) / step);
  return rates_[std::min(number, rates_.size() - 1)];
}

double
RateTrace::endOf(double begin, std::size_t bytes) const
{
  double bits = 8.0 * static_cast<double>(bytes);
  if (isSteady())
    return begin + bits / rates_.front();
  double time = begin;
  auto number = static_cast<std::size_t>(begin / step);
  while (number + 1 < rates_.size()) {
    const double end = static_cast<double>(number + 1) * step;
    const double room = rates_[number] * (end - time);
    if (bits <= room)
      break;
    bits -= room;
    time = end;
    ++number;
  }
  return time + bits / rates_[std::min(number, rates_.size() - 1)];
}

double
SimulatedLink::send(double time, std::size_t bytes)
{
  busy_until_ = trace_.endOf(std::max(time, busy_until_), bytes);
  return busy_until_;
}

} // namespace shown
} // namespace pcl_ext

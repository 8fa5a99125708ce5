// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Links whose rate changes by fixed traces.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace shown {

/** \brief The rate of a link over time. */
class RateTrace {
public:
  /** \brief Always the same rate, bits a second. */
  static RateTrace
  steady(const std::string& name, double bits_per_second);

  /** \brief As of a Wi-Fi whose sender moves: a rate that walks in steps of a quarter
   * of a second, and drops to hardly anything for 0.2 to 1.2 seconds now and then.
   * \param[in] bits_per_second its highest value
   * \param[in] seconds length; the last rate stays
   */
  static RateTrace
  wireless(const std::string& name,
           double bits_per_second,
           double seconds,
           std::uint32_t seed);

  const std::string&
  name() const
  {
    return name_;
  }

  bool
  isSteady() const
  {
    return rates_.size() == 1;
  }

  /** \brief Bits a second at a time, seconds from 0. */
  double
  at(double time) const;

  /** \brief When a link that begins to send bytes has sent them. */
  double
  endOf(double begin, std::size_t bytes) const;

private:
  static constexpr double step = 0.05; // seconds of a rate

  std::string name_;
  std::vector<double> rates_;
};

/** \brief A link that sends frames one after the other. */
class SimulatedLink {
public:
  /** \param[in] trace must outlive this */
  explicit SimulatedLink(const RateTrace& trace) : trace_(trace) {}

  /** \brief How long the next frame would wait, seconds. */
  double
  waitAt(double time) const
  {
    return busy_until_ > time ? busy_until_ - time : 0.0;
  }

  /** \brief Sends a frame.
   * \return when it has arrived
   */
  double
  send(double time, std::size_t bytes);

private:
  const RateTrace& trace_;
  double busy_until_ = 0.0;
};

} // namespace shown
} // namespace pcl_ext

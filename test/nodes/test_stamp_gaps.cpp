// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/impl/cloud_sender.h>

#include "nodes/stamp_gaps.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <random>
#include <utility>
#include <vector>

namespace {

using namespace std::chrono_literals;
using namespace pcl_ext::nodes;

class Sensor {
public:
  /** \param[in] loss share of the clouds that are lost
   * \param[in] jitter standard deviation of the stamps, ms
   */
  Sensor(double loss, double jitter) : loss_(loss), jitter_(jitter) {}

  void
  send(std::size_t clouds, Time period = 50ms)
  {
    for (std::size_t i = 0; i < clouds; ++i) {
      time_ += period;
      const bool is_lost = i > 0 && i + 1 < clouds && uniform_(random_) < loss_;
      lost += is_lost ? 1 : 0;
      if (is_lost)
        continue;
      const double jitter = jitter_ * normal_(random_);
      counted += gaps.missingBefore(time_ + Time(static_cast<Time::rep>(1e6 * jitter)));
    }
  }

  void
  pause(Time length)
  {
    time_ += length;
  }

  StampGaps gaps;
  std::size_t lost = 0;
  std::size_t counted = 0;

private:
  double loss_;
  double jitter_;
  std::normal_distribution<double> normal_;
  std::mt19937_64 random_{7};
  std::uniform_real_distribution<double> uniform_;
  Time time_ = 1700000000s;
};

TEST(StampGaps, LossesAreCounted)
{
  // With a large jitter losses cannot be told, but none is made up.
  using Jitters = std::vector<double>;
  for (const auto& [loss, jitters] :
       {std::pair(0.0, Jitters{0.0, 1.0, 3.0, 10.0, 25.0}),
        std::pair(0.02, Jitters{0.0, 1.0, 3.0}),
        std::pair(0.3, Jitters{0.0, 1.0, 3.0}),
        std::pair(0.58, Jitters{0.0, 1.0, 3.0})})
    for (const double jitter : jitters) {
      Sensor sensor(loss, jitter);
      for (int part = 0; part < 5; ++part) {
        sensor.send(1000);
        sensor.pause(1h);
      }
      EXPECT_NEAR(static_cast<double>(sensor.counted),
                  static_cast<double>(sensor.lost),
                  0.1 * static_cast<double>(sensor.lost))
          << loss << " of the clouds, jitter " << jitter << " ms";
    }
}

/** \brief Clouds that are missing by the intervals between them, ms. */
template <typename NextInterval>
std::size_t
missingBetween(std::size_t clouds, const NextInterval& next)
{
  StampGaps gaps;
  double time = 1.7e12;
  std::size_t missing = 0;
  for (std::size_t i = 0; i < clouds; ++i) {
    time += next(i);
    missing += gaps.missingBefore(Time(static_cast<Time::rep>(1e6 * time)));
  }
  return missing;
}

TEST(StampGaps, CloudsOfEventsAreNotLost)
{
  for (unsigned int seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    std::exponential_distribution<double> waiting(1.0 / 50.0);
    EXPECT_EQ(missingBetween(5000, [&](std::size_t) { return waiting(random); }), 0u)
        << "seed " << seed;
    std::uniform_real_distribution<double> uneven(20.0, 200.0);
    EXPECT_EQ(missingBetween(5000, [&](std::size_t) { return uneven(random); }), 0u)
        << "seed " << seed;
  }
}

TEST(StampGaps, BurstsAreNotLosses)
{
  for (const std::size_t length : {2, 3, 5, 10})
    for (const double jitter : {0.0, 1.0}) { // ms
      std::mt19937_64 random(7);
      std::normal_distribution<double> normal;
      std::uniform_real_distribution<double> pause(200.0, 600.0);
      const auto bursts = [&](std::size_t i, double pause_length) {
        return (i % length == 0 ? pause_length : 33.0) + jitter * normal(random);
      };
      // A multiple of the period, a fraction of it, and any.
      for (const double same : {330.0, 345.0})
        EXPECT_EQ(missingBetween(5000, [&](std::size_t i) { return bursts(i, same); }),
                  0u)
            << length << " clouds, jitter " << jitter << " ms, then " << same << " ms";
      EXPECT_EQ(
          missingBetween(5000, [&](std::size_t i) { return bursts(i, pause(random)); }),
          0u)
          << length << " clouds, jitter " << jitter << " ms";
    }
}

TEST(StampGaps, CloudsThatWereHeldUpAreNotLost)
{
  // One of ten clouds is lost; one of forty comes three periods late with the next
  // three.
  const std::size_t counted = missingBetween(4000, [](std::size_t i) {
    if (i % 10 == 5)
      return 2.0 * 50.0;
    if (i % 40 == 0)
      return 4.0 * 50.0;
    return i % 40 <= 3 ? 0.1 : 50.0;
  });
  EXPECT_GT(counted, 360u);
  EXPECT_LT(counted, 440u);
}

TEST(StampGaps, PausesAndOtherRatesAreNotLosses)
{
  Sensor sensor(0.0, 1.0);
  sensor.send(100);
  sensor.pause(1h);
  sensor.send(100);
  sensor.pause(-1h); // a recording that begins anew
  sensor.send(100);
  sensor.send(100, 20ms);
  EXPECT_EQ(sensor.counted, 0u);
  sensor.send(1000, 100ms);
  EXPECT_LT(sensor.counted, 120u); // four for each of 30, until the new rate is known
}

TEST(StampGaps, CloudsWithoutStampSayNothing)
{
  StampGaps gaps;
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(gaps.missingBefore(Time(0)), 0u);
}

TEST(StampGaps, ASenderReportsThem)
{
  CloudSender sender;
  for (int cloud = 0; cloud < 100; ++cloud)
    if (cloud % 4 != 3) // every fourth is lost
      sender.countMissedBefore(1700000000s + cloud * 50ms);
  // Of the first ones, which show the period, none.
  EXPECT_GE(sender.health().clouds_missed, 20u);
  EXPECT_LE(sender.health().clouds_missed, 25u);
  const HealthReport report =
      describeHealth(sender.health(), CloudSender().health(), Time(0));
  EXPECT_EQ(report.level(), HealthLevel::Stale); // none was encoded
}

} // namespace

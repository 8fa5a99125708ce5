/** \file
 * \brief Waiting for what other threads and processes do, never for a time.
 */
#pragma once

#include <chrono>
#include <thread>

namespace pcl_ext_ros {
namespace test {

/** \brief Generous, as it only passes where a test fails: on a busy computer a node takes
 * seconds to start. */
constexpr double seconds_to_wait = 30.0;

/** \brief Returns when a condition holds, or does not in time.
 * \return the condition
 */
template <typename ConditionT>
bool
waitFor(const ConditionT& condition, double seconds = seconds_to_wait)
{
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (Clock::now() >= end)
      return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

} // namespace test
} // namespace pcl_ext_ros

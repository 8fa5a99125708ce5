// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "rate/rate_control.h"
#include "support/checked_link.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief What a cloud costs on the finest step, with effort balanced. */
struct CloudCost {
  double bytes = 0.0; ///< of a P-frame
  double encode_ms = 0.0;
};

/** \brief A RateControl with an encoder whose frames have sizes by step, and the link. */
class RatedStream {
public:
  using Nanoseconds = std::chrono::nanoseconds;

  explicit RatedStream(const EncoderSettings& settings)
  : control_(settings)
  , link_(settings.max_rate > 0.0 ? settings.max_rate : 1e12, settings.rate_buffer)
  , i_frame_rate_(settings.i_frame_rate)
  {}

  /** \brief Encodes a cloud.
   * \param[in] elapsed since the last one
   * \return whether its frame was sent
   */
  bool
  send(Nanoseconds elapsed, const CloudCost& cost)
  {
    stamp_ += elapsed;
    link_.advance(elapsed);
    return sendAt(stamp_, cost);
  }

  /** \brief The same at a stamp; the link is told by the caller. */
  bool
  sendAt(Nanoseconds stamp, const CloudCost& cost)
  {
    const bool is_due = is_i_frame_requested_ || since_i_frame_ >= i_frame_rate_;
    if (!control_.beginCloud(stamp, is_due))
      return false;
    ++encoded_;
    const bool is_i_frame = is_due || control_.hasChanged();
    const auto bytes = static_cast<std::size_t>(cost.bytes * sizeOfStep(is_i_frame));
    const Nanoseconds time(
        static_cast<Nanoseconds::rep>(1e6 * cost.encode_ms * timeOfStep()));
    is_i_frame_requested_ =
        !control_.endFrame(bytes, is_i_frame, time, VoxelGrid(), sensor_motion_);
    since_i_frame_ = is_i_frame ? 1 : since_i_frame_ + 1;
    // Only whether the sensor moves changes the step with a frame.
    EXPECT_TRUE(!control_.hasChanged() ||
                control_.status().reason == "the sensor moves" ||
                control_.status().reason == "the sensor rests");
    if (is_i_frame_requested_)
      return false;
    link_.add(bytes);
    return true;
  }

  /** \brief Sends clouds at 10 Hz.
   * \return how many were sent
   */
  std::size_t
  sendFor(std::chrono::seconds duration, const CloudCost& cost)
  {
    std::size_t sent = 0;
    for (std::int64_t i = 0; i < 10 * duration.count(); ++i)
      sent += send(std::chrono::milliseconds(100), cost) ? 1 : 0;
    return sent;
  }

  /** \brief Of the frames from now on; those of a sensor at rest take fewer bytes with
   * the temporal filter. */
  void
  setSensorMotion(SensorMotion motion)
  {
    sensor_motion_ = motion;
  }

  std::size_t
  encoded() const
  {
    return encoded_;
  }

  RateControl&
  control()
  {
    return control_;
  }

  RateControlStatus
  status() const
  {
    return control_.status();
  }

  CheckedLink&
  link()
  {
    return link_;
  }

private:
  double
  sizeOfStep(bool is_i_frame) const
  {
    const EncoderSettings& settings = control_.settings();
    const double effort = settings.effort == Effort::Fast    ? 1.1
                          : settings.effort == Effort::Small ? 0.95
                                                             : 1.0;
    const bool is_filtered =
        settings.temporal_filter != 0 && sensor_motion_ == SensorMotion::AtRest;
    const double filter = !is_filtered ? 1.0 : is_i_frame ? 0.9 : 0.5;
    const double bits = settings.intensity_curve == IntensityCurve::Linear ? 1.0 : 0.85;
    return effort * filter * bits * (is_i_frame ? 1.25 : 1.0) *
           std::pow(0.4, doublings());
  }

  double
  timeOfStep() const
  {
    const Effort effort = control_.settings().effort;
    return (effort == Effort::Fast    ? 0.4
            : effort == Effort::Small ? 1.7
                                      : 1.0) *
           std::pow(0.4, doublings());
  }

  double
  doublings() const
  {
    return control_.status().step.doublings;
  }

  RateControl control_;
  CheckedLink link_;
  Nanoseconds stamp_{0};
  unsigned int i_frame_rate_;
  unsigned int since_i_frame_ = 0;
  std::size_t encoded_ = 0;
  bool is_i_frame_requested_ = true;
  SensorMotion sensor_motion_ = SensorMotion::AtRest;
};

} // namespace pcl_ext::PCL_EXT_ABI::io::test

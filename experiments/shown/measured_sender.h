// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A sensor's node, a link and a receiver, and what is shown.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "measuring/samples.h"
#include "shown_quality.h"
#include "simulated_link.h"

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext {
namespace shown {

/** \brief One sender over one link, with a setting that is fixed or with a budget. */
class MeasuredSender {
public:
  /** \brief How long a frame may wait before a sender without a budget drops it, and the
   * next frame is an I-frame; with one it is the rate_buffer. */
  static constexpr double buffer_seconds = 0.25;

  /** \param[in] settings with max_rate: it follows the link, as of one cloud before
   * \param[in] trace, judge must outlive this
   */
  MeasuredSender(std::string name,
                 const nodes::SensorNodeSettings& settings,
                 const RateTrace& trace,
                 QualityJudge& judge);

  /** \brief Sends a cloud.
   * \param[in] next_time of the next cloud, until which it can arrive to be shown in time
   */
  void
  send(const pcl::PCLPointCloud2& cloud,
       const WorldPose& pose,
       double time,
       double next_time);

  const std::string&
  name() const
  {
    return name_;
  }

  bool
  hasBudget() const
  {
    return has_budget_;
  }

  std::size_t
  changes() const
  {
    return node_->statistics().rate_control.changes;
  }

  std::size_t first_judged = 0; ///< cloud from which on what is shown is judged

  measuring::Samples surface_percent; ///< of each judged cloud
  measuring::Samples noise_percent;
  measuring::Samples person_percent;
  measuring::Samples frame_bytes; ///< of frames that were sent
  measuring::Samples encode_ms;   ///< processor time
  measuring::Samples decode_ms;
  measuring::Samples arrival_ages; ///< of frames when they arrive
  double largest_load = 0.0;       ///< of a second's budget, in any second
  std::size_t clouds_left_out = 0;

private:
  struct Frame {
    double time;
    double arrival;
    std::vector<std::uint8_t> bytes;
  };

  bool
  encode(const pcl::PCLPointCloud2& cloud,
         const WorldPose& pose,
         double time,
         std::vector<std::uint8_t>& bytes);

  void
  receive(double time);

  std::string name_;
  bool has_budget_;
  const RateTrace& trace_;
  SimulatedLink link_;
  QualityJudge& judge_;
  double time_ = 0.0; // of the node's clock
  double last_rate_time_ = 0.0;
  std::unique_ptr<nodes::SensorNode> node_;
  io::FrameDecoder decoder_;
  std::deque<Frame> frames_; // on their way
  io::VoxelFrame received_;
  io::VoxelFrame shown_;
  std::size_t clouds_ = 0;
  std::deque<std::pair<nodes::Time, double>> loads_; // of frames of the last second
};

} // namespace shown
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/status.h>

#include "cloud_columns.h"
#include "outlier_filter.h"
#include "stream_settings.h"

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

namespace pcl_ext::python {

struct CloudToEncode {
  const CloudColumns& columns;
  bool has_intensity_argument = false; ///< not a field that came along
  std::optional<io::FrameStamp> stamp;
  std::optional<WorldPose> sensor_pose; ///< sensor -> cloud; none: that of the settings
  OutlierFilter* outliers = nullptr;
};

/** \brief Encodes the clouds of one stream: OctreePointCloudIntensityCompression's half
 * of it for columns, with a law that is chosen at run time.
 *
 * Any thread may call it, and not with the GIL held, as a call may wait for another
 * thread.
 */
class ArrayEncoder {
public:
  /** \param[in] settings checked */
  explicit ArrayEncoder(const ArrayEncoderSettings& settings);

  /** \brief Encodes the next cloud.
   * \param[in] cloud must not change meanwhile
   * \param[out] bytes the frame; empty unless the status is Ok
   * \return LeftOut, too, if the rate has no room for it
   * \throws std::invalid_argument if the cloud lacks the intensities of the law, or has
   * ones that it does not use
   */
  io::CompressionStatus
  encode(const CloudToEncode& cloud, std::vector<std::uint8_t>& bytes);

  void
  requestIFrame();

  /** \brief See io::CloudEncoder. */
  void
  setMaxRate(double bits_per_second);

  io::RateControlStatus
  rateControl() const;

  io::FrameStatistics
  statistics() const;

  /** \brief The law; none until the first cloud with points decides. */
  std::optional<IntensityLaw>
  law() const;

private:
  class Source;

  void
  start(IntensityLaw law);

  void
  chooseLaw(const CloudColumns& columns);

  std::optional<io::DepthLaw>
  depthLawAt(double resolution) const;

  void
  checkIntensities(const CloudToEncode& cloud) const;

  mutable std::mutex mutex_;
  ArrayEncoderSettings settings_;
  std::optional<io::CloudEncoder> encoder_; // from the first cloud on
  IntensityLaw law_ = IntensityLaw::None;   // of encoder_
  std::optional<double> max_rate_;          // that was set before
  // Members so that their memory is reused.
  CloudMemory memory_;
  std::vector<float> intensities_;
};

} // namespace pcl_ext::python

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/point_outlier_removal.h>

#include "bytes/exceptions.h"
#include "outliers/lidar_image.h"
#include "outliers/range_continuity.h"

#include <limits>

namespace pcl_ext::PCL_EXT_ABI {

class PointOutlierRemoval::Implementation {
public:
  explicit Implementation(const PointOutlierRemovalSettings& settings)
  : settings_(settings), settings_status_(checkSettings(settings))
  {}

  const PointOutlierRemovalSettings&
  settings() const
  {
    return settings_;
  }

  OutlierRemovalStatus
  score(const io::PointView& points, std::vector<float>& log_odds)
  {
    return callOrCleanUp([&] { return judge(points, log_odds); }, [&] { reset(); });
  }

  void
  reset()
  {
    image_ = LidarImage();
    continuity_.reset();
  }

private:
  OutlierRemovalStatus
  judge(const io::PointView& points, std::vector<float>& log_odds)
  {
    log_odds.assign(points.count, std::numeric_limits<float>::infinity());
    if (!settings_status_.ok())
      return settings_status_;
    if (!image_.assign(points)) {
      continuity_.reset();
      return {
          OutlierRemovalCode::NoImage,
          "no point was judged: neither rows and columns, nor a field 'ring', nor the "
          "directions of the points tell the rows of a lidar that turns around z; "
          "points must be in the sensor's coordinates"};
    }
    continuity_.score(image_.ranges(),
                      image_.width(),
                      image_.height(),
                      settings_.use_history,
                      pixel_log_odds_);
    OutlierRemovalStatus status;
    for (std::size_t i = 0; i < points.count; ++i) {
      if (image_.pixels()[i] == no_pixel)
        continue;
      log_odds[i] = pixel_log_odds_[image_.pixels()[i]];
      status.removed += log_odds[i] < settings_.min_log_odds ? 1 : 0;
    }
    return status;
  }

  PointOutlierRemovalSettings settings_;
  OutlierRemovalStatus settings_status_;
  LidarImage image_;
  RangeContinuity continuity_;
  std::vector<float> pixel_log_odds_;
};

PointOutlierRemoval::PointOutlierRemoval(const PointOutlierRemovalSettings& settings)
: implementation_(std::make_unique<Implementation>(settings))
{}

PointOutlierRemoval::~PointOutlierRemoval() = default;
PointOutlierRemoval::PointOutlierRemoval(PointOutlierRemoval&&) noexcept = default;
PointOutlierRemoval&
PointOutlierRemoval::operator=(PointOutlierRemoval&&) noexcept = default;

const PointOutlierRemovalSettings&
PointOutlierRemoval::settings() const
{
  return implementation_->settings();
}

OutlierRemovalStatus
PointOutlierRemoval::score(const io::PointView& points, std::vector<float>& log_odds)
{
  return implementation_->score(points, log_odds);
}

void
PointOutlierRemoval::reset()
{
  implementation_->reset();
}

} // namespace pcl_ext::PCL_EXT_ABI

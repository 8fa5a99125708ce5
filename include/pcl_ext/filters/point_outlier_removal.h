// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/export.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/version.h>

#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup filters
 * @{ */

/** \brief All settings of a PointOutlierRemoval, with their units, defaults and
 * ranges. */
struct PointOutlierRemovalSettings {
  /** \brief Points of lower log-odds are noise. Natural logarithm, finite; points have
   * about -6 to 10. For the shares of noise and surfaces that it removes see
   * doc/outlier_removal.md. */
  float min_log_odds = 0.0f;

  /** \brief Also use the last cloud, as long as the sensor stands still. Off: each cloud
   * is filtered independently. */
  bool use_history = true;

  friend bool
  operator==(const PointOutlierRemovalSettings& a, const PointOutlierRemovalSettings& b)
  {
    return a.min_log_odds == b.min_log_odds && a.use_history == b.use_history;
  }
};

/** \brief Checks the settings against their ranges.
 * \return Ok, or InvalidSettings with the field and its value
 */
PCL_EXT_CODEC_EXPORT OutlierRemovalStatus
checkSettings(const PointOutlierRemovalSettings& settings);

/** \brief Tells snow and other noise that floats in the air from surfaces in the clouds
 * of a lidar that turns, at the sensor, before they become voxels.
 *
 * Each point is judged by the ranges of the rays around it: a surface goes on in its row
 * and in the rows beside it, noise floats in front of what the rays around it see. See
 * doc/outlier_removal.md for the formula.
 *
 * Rows are those of an organised cloud, else the field `ring`, else they are told from
 * the elevations of the points, or from turns that follow each other, as far as they are
 * distinct: the first of these whose rows are cones around z. Columns are found by the
 * azimuths, in the sensor's coordinates, whose z is the axis of its turns.
 *
 * One instance serves one sensor; calls must not overlap. Time and memory are
 * proportional to the number of points, and to rows times columns of a turn. If memory
 * runs out std::bad_alloc is thrown and the next cloud is judged without a history. A
 * moved-from instance may only be assigned to or destroyed.
 */
class PCL_EXT_CODEC_EXPORT PointOutlierRemoval {
public:
  explicit PointOutlierRemoval(
      const PointOutlierRemovalSettings& settings = PointOutlierRemovalSettings());
  ~PointOutlierRemoval();
  PointOutlierRemoval(PointOutlierRemoval&&) noexcept;
  PointOutlierRemoval&
  operator=(PointOutlierRemoval&&) noexcept;

  const PointOutlierRemovalSettings&
  settings() const;

  /** \brief Computes the log-odds of the points of the next cloud.
   * \param[in] points in the coordinates of the sensor, metres; coordinates, image,
   * pixels and the field `ring` are used
   * \param[out] log_odds natural logarithm of the odds of surface against noise, for
   * each point; plus infinity where none is judged: coordinates that are not finite,
   * the sensor's place, and points behind another one in the same direction
   * \return Ok with the number of points below min_log_odds; InvalidSettings; or
   * NoImage if there are no rows: then no point is judged, and after three such clouds
   * of 1000 points only each sixteenth one is looked at
   */
  OutlierRemovalStatus
  score(const io::PointView& points, std::vector<float>& log_odds);

  /** \brief Drops the history, as at the start of a stream. */
  void
  reset();

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

/** \file
 * \brief What is compared on labelled scans of lidars.
 *
 * A new method is one line of scanMethods(): pointMethod() with a function that scores
 * the points of a scan, at the sensor, or voxelMethod() with one that scores voxels, as
 * a receiver has them.
 */
#pragma once

#include "labelled_scans.h"
#include "methods.h"

#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief A way to score the points of a scan, or the voxels made of it; low for noise.
 * It is called for the scans of one stream in their order, so that it may remember. */
struct ScanMethod {
  /** \brief Sets a score for each point of the scan; those of missing points are not
   * used. No score may be NaN. */
  using PointScore = std::function<void(const LabelledScan&, std::vector<float>&)>;

  std::string name; ///< without a comma, for results

  /** \brief Empty where voxels are scored. */
  PointScore score_points;

  /** \brief Makes a way to score the voxels of an edge, metres. Empty where points are
   * scored. */
  std::function<Method::Score(double)> voxel_score;

  std::vector<float> thresholds; ///< of which the figures are wanted

  /** \brief The scores are 0 for what is removed and 1 for what stays: a curve of them
   * means nothing. */
  bool is_decision = false;
};

/** \brief A method that scores the points of a scan. */
ScanMethod
pointMethod(const std::string& name,
            ScanMethod::PointScore score,
            std::vector<float> thresholds = {});

/** \brief A method that scores points without regard to their order, as those of PCL. */
ScanMethod
cloudMethod(
    const std::string& name,
    const std::function<void(const Centres::ConstPtr&, std::vector<float>&)>& score,
    std::vector<float> thresholds = {});

/** \brief A method that scores voxels.
 * \param[in] score makes a way to score voxels of an edge, metres
 */
ScanMethod
voxelMethod(const std::string& name,
            std::function<Method::Score(double)> score,
            std::vector<float> thresholds = {});

/** \brief What a network says: a .label file for each scan, of its name.
 * \param[in] folder of the files
 * \param[in] meanings of their labels
 */
ScanMethod
predictions(const std::string& folder, const LabelMeanings& meanings);

/** \brief Angles between neighbouring rays of a lidar, degrees. */
struct RaySteps {
  double azimuth = 0.0; ///< in a ring
  double ring = 0.0;    ///< between rings
};

/** \brief All methods but predictions(). */
std::vector<ScanMethod>
scanMethods(const RaySteps& steps);

} // namespace noise
} // namespace pcl_ext

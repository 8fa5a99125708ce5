#pragma once

#include <pcl_ext/compression/region_settings.h>

#include <CLI/App.hpp>

#include <utility>
#include <vector>

namespace pcl_ext {
namespace tools {

/** \brief Options for regions with voxels of a larger edge. */
class RegionOptions {
public:
  /** \brief Adds --region and the other options. */
  void
  add(CLI::App& app);

  /** \brief The regions at a resolution, metres.
   * \throws UsageError for an edge that no region can have
   */
  io::RegionSettings
  settingsAt(double resolution) const;

  bool
  areAny() const
  {
    return !boxes_.empty() || settings_.coarser_beyond != 0.0;
  }

private:
  std::vector<std::pair<io::BoundingBox, double>> boxes_; // and the edges, metres
  io::RegionFrame frame_ = io::RegionFrame::World;        // of all boxes
  io::RegionSettings settings_;                           // all else
};

} // namespace tools
} // namespace pcl_ext

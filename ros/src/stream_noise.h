#pragma once

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "decompressor_parameters.h"
#include "stream_parameter.h"

#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief What is noise in one stream, followed while the node runs. */
class StreamNoise {
public:
  /** \brief Reads what is in force at the start.
   * \param[in] topic resolved name of the stream
   * \param[in] from_streams what ~streams says
   * \param[in] for_all of streams that nothing else is said of
   * \throws WrongParameter
   */
  StreamNoise(const std::string& topic,
              const StreamParameters& from_streams,
              const NoiseParameters& for_all);

  /** \brief Reads the parameters again.
   * \return true if minIntensity() is another one now
   */
  bool
  updateMinIntensity()
  {
    return min_intensity_.update();
  }

  /** \brief Reads the parameters again.
   * \return true if outlierRemoval() is another one now
   */
  bool
  updateOutlierRemoval();

  float
  minIntensity() const
  {
    return min_intensity_.current();
  }

  /** \brief None: outliers stay. */
  std::optional<pcl_ext::VoxelOutlierRemovalSettings>
  outlierRemoval() const;

private:
  StreamParameter<float> min_intensity_;
  StreamParameter<bool> remove_outliers_;
  StreamParameter<float> min_log_odds_;
};

} // namespace pcl_ext_ros

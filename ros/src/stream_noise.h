#pragma once

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "node_parameters.h"

#include <atomic>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief A setting of one stream that can change while the node runs.
 *
 * The value is that of the parameter ~<name>_of/<topic>, else that in ~streams, else that
 * of the parameter ~<name>, else the value so far.
 * \tparam ValueT float, for finite numbers, or bool
 */
template <typename ValueT>
class StreamSetting {
public:
  /** \brief Reads the value at the start.
   * \param[in] name of the setting
   * \param[in] topic resolved name of the stream
   * \param[in] from_streams value in ~streams
   * \param[in] for_all value of ~<name>
   * \throws WrongParameter
   */
  StreamSetting(const std::string& name,
                const std::string& topic,
                std::optional<ValueT> from_streams,
                ValueT for_all);

  ValueT
  current() const
  {
    return current_;
  }

  /** \brief Reads the parameters, which roscpp caches. A wrong value changes nothing; there
   * is one warning for it.
   * \return true if the value changed
   */
  bool
  update();

private:
  /** \brief The value of a parameter; nothing if it is not set. */
  std::optional<ValueT>
  read(const std::string& name);

  std::string own_name_;
  std::string name_for_all_;
  std::optional<ValueT> from_streams_;
  std::atomic<ValueT> current_; // timers of several threads read it
  std::string last_warning_;
};

/** \brief The noise settings of one stream. */
struct StreamNoise {
  /** \brief Reads the settings at the start.
   * \param[in] topic resolved name of the stream
   * \param[in] from_streams the stream's entry of ~streams
   * \param[in] for_all settings of all streams
   * \throws WrongParameter
   */
  StreamNoise(const std::string& topic,
              const StreamParameters& from_streams,
              const NoiseParameters& for_all);

  /** \brief Nothing if outliers are not removed. */
  std::optional<pcl_ext::VoxelOutlierRemovalSettings>
  outlierRemoval() const;

  /** \brief Reads the parameters of outlierRemoval().
   * \return true if it changed
   */
  bool
  updateOutlierRemoval();

  StreamSetting<float> min_intensity;
  StreamSetting<bool> remove_outliers;
  StreamSetting<float> min_log_odds;
  pcl_ext::DensityUnit density_unit; ///< does not change while the node runs
};

} // namespace pcl_ext_ros

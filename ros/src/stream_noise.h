#pragma once

#include <pcl_ext/nodes/node_parameters.h>

#include <atomic>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief A setting of one stream that can change while the node runs.
 *
 * The value is that of the parameter ~<name>_of/<topic>, else that in ~streams, else that
 * of the parameter ~<name>, else the value so far.
 * \tparam ValueT type of the values: bool or double
 */
template <typename ValueT>
class StreamSetting {
public:
  /** \brief Reads the value at the start.
   * \param[in] name of one of noiseParameters()
   * \param[in] topic resolved name of the stream
   * \param[in] from_streams values in ~streams
   * \param[in] for_all values of ~<name>
   * \throws WrongParameter
   */
  StreamSetting(const std::string& name,
                const std::string& topic,
                const pcl_ext::nodes::ParameterValues& from_streams,
                const pcl_ext::nodes::ParameterValues& for_all);

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

  const pcl_ext::nodes::ParameterDescription& parameter_;
  std::string own_name_;
  std::string name_for_all_;
  std::optional<ValueT> from_streams_;
  std::atomic<ValueT> current_; // timers of several threads read it
  std::string last_warning_;
};

/** \brief The noise settings of one stream. */
class StreamNoise {
public:
  /** \brief Reads the settings at the start.
   * \param[in] topic resolved name of the stream
   * \param[in] from_streams values of noiseParameters() in the stream's entry of ~streams
   * \param[in] for_all those of all streams
   * \throws WrongParameter
   */
  StreamNoise(const std::string& topic,
              const pcl_ext::nodes::ParameterValues& from_streams,
              const pcl_ext::nodes::ParameterValues& for_all);

  float
  minIntensity() const;

  /** \brief Nothing if outliers are not removed. */
  std::optional<pcl_ext::VoxelOutlierRemovalSettings>
  outlierRemoval() const;

  /** \brief Reads the parameters of outlierRemoval().
   * \return true if it changed
   */
  bool
  updateOutlierRemoval();

  /** \brief Reads the parameter of minIntensity().
   * \return true if it changed
   */
  bool
  updateMinIntensity();

private:
  /** \brief The settings at present. */
  pcl_ext::nodes::NoiseSettings
  settings() const;

  StreamSetting<double> min_intensity_;
  StreamSetting<bool> remove_outliers_;
  StreamSetting<double> min_log_odds_;
  pcl_ext::nodes::ParameterValues constant_values_; // do not change while the node runs
};

} // namespace pcl_ext_ros

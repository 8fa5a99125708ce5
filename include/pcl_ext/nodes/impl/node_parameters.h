// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/sensor_node.h>
#include <pcl_ext/nodes/stream_health.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

struct MergingCentreSettings;

/** \brief A value as parameter files have it. */
using ParameterValue =
    std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

/** \brief Values by the names of the parameters. */
using ParameterValues = std::map<std::string, ParameterValue>;

/** \brief One parameter of a node: its type is that of its default.
 *
 * The default is allowed even where it is not in the range: a number 0, an empty text
 * or an empty list then stands for "not set".
 */
struct ParameterDescription {
  std::string name;
  std::string unit; ///< "m", "frames"; empty: none
  ParameterValue default_value;

  /** \brief Range of numbers and of the elements of lists, both ends included. All
   * finite numbers unless it is set; that of an integer is within [-2^31, 2^31). */
  double lowest = std::numeric_limits<double>::lowest();
  double highest = std::numeric_limits<double>::max();

  std::size_t list_size = 0;      ///< number of elements of a list; 0: any
  std::vector<std::string> words; ///< texts that are allowed; empty: any but ''
  std::string description;        ///< what it is for, in one sentence
  bool may_be_zero = false;       ///< a number may be 0 whatever its range
};

/** \brief The parameter of a name.
 * \throws std::out_of_range if there is none
 */
PCL_EXT_EXPORT const ParameterDescription&
descriptionOf(const std::vector<ParameterDescription>& parameters,
              const std::string& name);

/** \brief The allowed values, for messages and tables: "a number from 0 to 1". */
PCL_EXT_EXPORT std::string
allowedValues(const ParameterDescription& parameter);

/** \brief Whether the values of a parameter that is a number are those of its range, and
 * no other one beside it. */
PCL_EXT_EXPORT bool
isInterval(const ParameterDescription& parameter);

/** \brief Converts a value to the type of a parameter and checks its range. A whole
 * number is accepted for a number, and for a list of numbers its text, such as
 * "[0, 0.5]"; no other conversion is made.
 * \return the value; nothing if it is not allowed
 */
PCL_EXT_EXPORT std::optional<ParameterValue>
convertedValue(const ParameterDescription& parameter, const ParameterValue& value);

/** \brief A value in one line, for messages: true, 4, 0.04, 'fast', [0, 0, 1]. Numbers
 * have as many digits as tell them from all others. */
PCL_EXT_EXPORT std::string
textOf(const ParameterValue& value);

/** \brief A parameter that cannot be used, in one line with its name, its value and the
 * values that are allowed: "effort is 'quick'; it must be one of: fast, balanced,
 * small". */
PCL_EXT_EXPORT std::string
refusalOf(const ParameterDescription& parameter, const ParameterValue& value);

/** \brief The defaults of some parameters. */
PCL_EXT_EXPORT ParameterValues
defaultsOf(const std::vector<ParameterDescription>& parameters);

/** \brief The value of a parameter.
 * \tparam ValueT the alternative of ParameterValue that the parameter has
 * \throws std::out_of_range or std::bad_variant_access if there is no such value
 */
template <typename ValueT>
const ValueT&
valueOf(const ParameterValues& values, const std::string& name)
{
  return std::get<ValueT>(values.at(name));
}

/** \brief The parameters of encoding: the settings of the codec, and what else of
 * SensorNodeSettings users set, except for the global coordinate frame. They have the
 * names of the fields; `intensity` is the law, where the word automatic means native
 * for clouds with the field `intensity_field`, else none. */
PCL_EXT_EXPORT const std::vector<ParameterDescription>&
encodingParameters();

/** \brief The parameters of decoding: those of removing noise, `min_intensity`,
 * `remove_outliers`, `min_log_odds`, `density_unit`, and `packed`. */
PCL_EXT_EXPORT const std::vector<ParameterDescription>&
noiseParameters();

/** \brief The parameters of a sensor's node besides encodingParameters():
 * `global_frame`, `tf_timeout`, `queue_size`. Read at the start. */
PCL_EXT_EXPORT const std::vector<ParameterDescription>&
sensorNodeParameters();

/** \brief The parameters of a central node besides its topics and noiseParameters():
 * those of MergingCentreSettings that users set, of merging, of the map and of the view.
 * Read at the start. */
PCL_EXT_EXPORT const std::vector<ParameterDescription>&
centralNodeParameters();

/** \brief The parameters of one stream of a central node besides noiseParameters():
 * `sensor_frame`. Read at the start. */
PCL_EXT_EXPORT const std::vector<ParameterDescription>&
streamParameters();

/** \brief The settings of a sensor's node.
 * \param[in] values of encodingParameters(); one that is missing has its default, and
 * values of other names are ignored
 * \param[in] has_intensities for automatic: whether the clouds have the field
 * `intensity_field`
 * \param[in,out] settings what the parameters say; the rest, and all if something is
 * wrong, is unchanged
 * \return what is wrong, in one line that begins with the name of a parameter: a value
 * that is not allowed, or values that contradict each other or the rest of the
 * settings; empty if nothing
 */
PCL_EXT_EXPORT std::string
readEncodingParameters(const ParameterValues& values,
                       bool has_intensities,
                       SensorNodeSettings& settings);

/** \brief What is wrong with values of encodingParameters(), as
 * readEncodingParameters() says it, for clouds with or without intensities; empty if
 * nothing. */
PCL_EXT_EXPORT std::string
faultOfEncodingParameters(const ParameterValues& values);

/** \brief The settings of a central node.
 * \param[in] values of centralNodeParameters(), each as convertedValue() returns it;
 * one that is missing has its default
 * \param[in] clock that stamps the clouds
 * \throws std::bad_variant_access or std::out_of_range for a value that is not allowed
 */
PCL_EXT_EXPORT MergingCentreSettings
readCentralNodeParameters(const ParameterValues& values, Clock clock);

/** \brief What noiseParameters() say. */
struct NoiseSettings {
  float min_intensity = 0.0f; ///< voxels below are removed; 0: none
  std::optional<VoxelOutlierRemovalSettings> outlier_removal; ///< none: outliers stay
  bool is_packed = false; ///< messages do not get the layout of those that were encoded

  /** \brief min_intensity as of CentralNode::setMinIntensity(). */
  PCL_EXT_EXPORT float
  lowestIntensity() const;
};

/** \brief The settings of removing noise.
 * \param[in] values of noiseParameters(), each as convertedValue() returns it; one that
 * is missing has its default, and values of other names are ignored
 * \throws std::bad_variant_access or std::out_of_range for a value that is not allowed
 */
PCL_EXT_EXPORT NoiseSettings
readNoiseParameters(const ParameterValues& values);

} // namespace pcl_ext::PCL_EXT_ABI::nodes

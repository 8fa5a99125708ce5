// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/impl/named_value.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup intensity
 * @{ */

/** \brief The laws that can be chosen at run time; see CountLaw, QuadraticLaw,
 * LinearLaw, NativeLaw and NoIntensity. */
enum class IntensityLaw {
  Count,     ///< the number of points in a voxel
  Quadratic, ///< share of a voxel face that they cover; needs the sensor
  Linear,    ///< as quadratic, with more weight for near points; needs the sensor
  Native,    ///< the sensor's own intensity; needs a field of the clouds
  None       ///< no intensity: positions alone
};

inline constexpr std::array<NamedValue<IntensityLaw>, 5> intensity_laws = {
    {{IntensityLaw::Count, "count"},
     {IntensityLaw::Quadratic, "quadratic"},
     {IntensityLaw::Linear, "linear"},
     {IntensityLaw::Native, "native"},
     {IntensityLaw::None, "none"}}};

/** \brief Name of a law. */
inline std::string
nameOf(IntensityLaw law)
{
  return nameOf(intensity_laws, law);
}

/** \brief True if a law needs the sensor's field of view and size. */
constexpr bool
needsSensor(IntensityLaw law)
{
  return law == IntensityLaw::Quadratic || law == IntensityLaw::Linear;
}

/** \brief The law of clouds for which none is named.
 * \param[in] has_intensities whether the clouds have the field that Native reads
 */
constexpr IntensityLaw
automaticLaw(bool has_intensities)
{
  return has_intensities ? IntensityLaw::Native : IntensityLaw::None;
}

/** \brief A law or, as "automatic", none: then the clouds decide, by automaticLaw(). */
using LawChoice = std::optional<IntensityLaw>;

/** \brief All choices of a law, "automatic" first. */
inline std::vector<NamedValue<LawChoice>>
lawChoices()
{
  std::vector<NamedValue<LawChoice>> choices = {{std::nullopt, "automatic"}};
  for (const NamedValue<IntensityLaw>& law : intensity_laws)
    choices.push_back({law.value, law.name});
  return choices;
}

/** \brief The sensors that have a type. */
inline constexpr std::array<NamedValue<RuntimeSensor>, 3> named_sensors = {
    {{runtimeSensor(KinectV2()), "kinect_v2"},
     {runtimeSensor(KinectV1()), "kinect_v1"},
     {runtimeSensor(AzureKinectNfovUnbinned()), "azure_kinect_nfov"}}};

/** \brief Calls a visitor with the intensity model of a law; the only place where the
 * value of a law becomes a type.
 * \param[in] law the law
 * \param[in] resolution voxel edge, metres, above 0
 * \param[in] sensor field of view and size; needed where needsSensor(law)
 * \param[in] visitor takes any IntensityModel; returns the same type for all
 * \return what the visitor returns
 * \throws std::invalid_argument if the law is none of the above or lacks its sensor
 */
template <typename VisitorT>
decltype(auto)
visitIntensityModel(IntensityLaw law,
                    double resolution,
                    const std::optional<RuntimeSensor>& sensor,
                    VisitorT&& visitor)
{
  if (needsSensor(law) && !sensor)
    detail::throwInvalidArgument("the intensity law '" + nameOf(law) +
                                 "' needs a sensor");
  switch (law) {
  case IntensityLaw::Count:
    return visitor(CountIntensity(resolution));
  case IntensityLaw::Quadratic:
    return visitor(IntensityModel<RuntimeSensor, QuadraticLaw>(resolution, *sensor));
  case IntensityLaw::Linear:
    return visitor(IntensityModel<RuntimeSensor, LinearLaw>(resolution, *sensor));
  case IntensityLaw::Native:
    return visitor(NativeIntensity(resolution));
  case IntensityLaw::None:
    return visitor(NoIntensity(resolution));
  }
  detail::throwInvalidArgument("unknown intensity law");
}

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup intensity
 * @{ */

namespace detail {

/** \brief Throws std::invalid_argument; in a build without exceptions aborts the
 * program. */
[[noreturn]] inline void
throwInvalidArgument(const std::string& message)
{
#if defined(__cpp_exceptions) || defined(_CPPUNWIND)
  throw std::invalid_argument(message);
#else
  static_cast<void>(message);
  std::abort();
#endif
}

} // namespace detail

/** \brief Microsoft Kinect for Xbox One (time of flight), as in section 2.5 of Dybedal,
 * Aalerud and Hovland, Sensors 2019, 19(3), 636.
 *
 * Contract of a sensor type: the members fov_x_deg and fov_y_deg (horizontal and
 * vertical field of view, degrees, each above 0 and below 180), columns and rows (depth
 * image size, pixels, each above 0), static or not.
 */
struct KinectV2 {
  static constexpr double fov_x_deg = 70.6;
  static constexpr double fov_y_deg = 60.0;
  static constexpr unsigned int columns = 512;
  static constexpr unsigned int rows = 424;
};

/** \brief Microsoft Kinect for Xbox 360 (structured light); figures of Microsoft's
 * "Kinect for Windows Sensor Components and Specifications": 57 x 43 degrees. */
struct KinectV1 {
  static constexpr double fov_x_deg = 57.0;
  static constexpr double fov_y_deg = 43.0;
  static constexpr unsigned int columns = 640;
  static constexpr unsigned int rows = 480;
};

/** \brief Azure Kinect DK, narrow field of view, unbinned; figures of Microsoft's
 * "Azure Kinect DK hardware specifications": 75 x 65 degrees, 640 x 576. */
struct AzureKinectNfovUnbinned {
  static constexpr double fov_x_deg = 75.0;
  static constexpr double fov_y_deg = 65.0;
  static constexpr unsigned int columns = 640;
  static constexpr unsigned int rows = 576;
};

/** \brief A sensor whose parameters are known at run time only, for example from a
 * parameter file. */
struct RuntimeSensor {
  /** \brief Checks the parameters of a sensor.
   * \param[in] horizontal_fov_deg horizontal field of view, degrees, in (0, 180)
   * \param[in] vertical_fov_deg vertical field of view, degrees, in (0, 180)
   * \param[in] image_columns width of the depth image, pixels, above 0
   * \param[in] image_rows height of the depth image, pixels, above 0
   * \throws std::invalid_argument if a parameter is outside its range
   */
  constexpr RuntimeSensor(double horizontal_fov_deg,
                          double vertical_fov_deg,
                          unsigned int image_columns,
                          unsigned int image_rows)
  : fov_x_deg(horizontal_fov_deg)
  , fov_y_deg(vertical_fov_deg)
  , columns(image_columns)
  , rows(image_rows)
  {
    for (const double fov : {fov_x_deg, fov_y_deg})
      if (!(fov > 0.0 && fov < 180.0))
        detail::throwInvalidArgument("field of view must be between 0 and 180 degrees, "
                                     "got " +
                                     std::to_string(fov));
    if (columns == 0 || rows == 0)
      detail::throwInvalidArgument("a sensor needs at least one column and one row");
  }

  double fov_x_deg;
  double fov_y_deg;
  unsigned int columns;
  unsigned int rows;
};

/** \brief The parameters of a sensor type.
 * \tparam SensorT see KinectV2 for the contract
 */
template <typename SensorT>
constexpr RuntimeSensor
runtimeSensor(const SensorT& sensor)
{
  return RuntimeSensor(sensor.fov_x_deg, sensor.fov_y_deg, sensor.columns, sensor.rows);
}

/** \brief The sensor of laws that do not depend on it (count, native). */
struct UnspecifiedSensor {};

/** \brief The share of a square metre that one pixel covers at a depth of one metre.
 *
 * c = 4 tan(FOV_x / 2) tan(FOV_y / 2) / (columns * rows), in m^2 per pixel at 1 m;
 * grows with the square of the depth (section 2.5.2 of the paper). Kinect V2: 7.532e-6.
 * \tparam SensorT see KinectV2 for the contract
 */
template <typename SensorT>
double
pixelFootprint(const SensorT& sensor)
{
  constexpr double half_degree_in_radians = 3.14159265358979323846 / 360.0;
  return 4.0 * std::tan(sensor.fov_x_deg * half_degree_in_radians) *
         std::tan(sensor.fov_y_deg * half_degree_in_radians) /
         (static_cast<double>(sensor.columns) * static_cast<double>(sensor.rows));
}

/** \brief Unit of the intensity of one point, which decides the unit of a decoded
 * voxel's intensity. */
enum class IntensityUnit {
  Points, ///< whole points; a voxel has the number of its points
  Share,  ///< a share of a full voxel face, 0..1; a voxel has 255 times its share
  Native, ///< the unit of the sensor's own intensity, which a voxel has, too
  None    ///< voxels have no intensity
};

/** \brief Every point counts one: I_p = 1 (section 2.5.1 of the paper).
 *
 * Contract of a law: the constants `unit`, `uses_depth` and `uses_native`, and
 * `float operator()(float relative_depth, float native) const`, which returns the point
 * intensity. `relative_depth` is the depth divided by the cut-off depth, clamped to
 * 0..1, and 0 if the law does not use depth; `native` is the sensor's own intensity,
 * and 0 if the law does not use it.
 */
struct CountLaw {
  static constexpr IntensityUnit unit = IntensityUnit::Points;
  static constexpr bool uses_depth = false;
  static constexpr bool uses_native = false;

  float
  operator()(float /*relative_depth*/, float /*native*/) const
  {
    return 1.0f;
  }
};

/** \brief The share of a voxel face that a point's pixel covers: I_p = 1 / N_p(z) =
 * (z / z_c)^2, at most 1 (section 2.5.2 of the paper). */
struct QuadraticLaw {
  static constexpr IntensityUnit unit = IntensityUnit::Share;
  static constexpr bool uses_depth = true;
  static constexpr bool uses_native = false;
  /** \brief Exponent of the relative depth, for the depth model of the coder. Laws that
   * are not a power of the depth have no such member. */
  static constexpr unsigned int depth_exponent = 2;

  float
  operator()(float relative_depth, float /*native*/) const
  {
    return relative_depth * relative_depth;
  }
};

/** \brief The depth divided by the cut-off depth: I_p = z / z_c, at most 1 (section
 * 2.5.3 of the paper). */
struct LinearLaw {
  static constexpr IntensityUnit unit = IntensityUnit::Share;
  static constexpr bool uses_depth = true;
  static constexpr bool uses_native = false;
  static constexpr unsigned int depth_exponent = 1;

  float
  operator()(float relative_depth, float /*native*/) const
  {
    return relative_depth;
  }
};

/** \brief The sensor's own intensity, scaled: I_p = scale * native. */
struct NativeLaw {
  static constexpr IntensityUnit unit = IntensityUnit::Native;
  static constexpr bool uses_depth = false;
  static constexpr bool uses_native = true;

  /** \brief Factor on the sensor's intensity; 1 keeps its unit. */
  float scale = 1.0f;

  float
  operator()(float /*relative_depth*/, float native) const
  {
    return scale * native;
  }
};

namespace detail {

/** \brief True for types that fulfil the contract of KinectV2. */
template <typename SensorT, typename = void>
struct IsSensor : std::false_type {};

template <typename SensorT>
struct IsSensor<SensorT,
                std::void_t<decltype(std::declval<SensorT>().fov_x_deg),
                            decltype(std::declval<SensorT>().fov_y_deg),
                            decltype(std::declval<SensorT>().columns),
                            decltype(std::declval<SensorT>().rows)>> : std::true_type {
};

/** \brief True for types that fulfil the contract of CountLaw. */
template <typename LawT, typename = void>
struct IsLaw : std::false_type {};

template <typename LawT>
struct IsLaw<LawT,
             std::void_t<decltype(LawT::unit),
                         decltype(LawT::uses_depth),
                         decltype(LawT::uses_native)>>
: std::is_invocable_r<float, const LawT&, float, float> {};

template <typename LawT, typename = void>
struct UsesDepth : std::false_type {};

template <typename LawT>
struct UsesDepth<LawT, std::enable_if_t<LawT::uses_depth>> : std::true_type {};

} // namespace detail

/** \brief The intensity of one point: a policy made of a sensor and a law.
 *
 * Contract of an intensity model: the constants `unit`, `uses_depth` and `uses_native`;
 * a constructor from the voxel edge in metres, unless the user passes an instance; and
 * `float operator()(float depth, float native) const`. Depth is along the optical axis
 * in the sensor's frame, in metres.
 *
 * \code
 * const pcl_ext::IntensityModel<pcl_ext::KinectV2, pcl_ext::QuadraticLaw> model(0.04);
 * for (float z = 0.5f; z < 10.0f; z += 0.1f)
 *   std::cout << z << ' ' << model(z) << '\n';
 * \endcode
 * \tparam SensorT field of view and resolution, see KinectV2 for the contract
 * \tparam LawT see CountLaw for the contract
 */
template <typename SensorT, typename LawT>
class IntensityModel {
public:
  using Sensor = SensorT;
  using Law = LawT;

  static_assert(
      detail::IsLaw<LawT>::value,
      "the second template argument must be a law, as pcl_ext::QuadraticLaw; the "
      "first one is the sensor");
  static_assert(
      detail::IsSensor<SensorT>::value || !detail::UsesDepth<LawT>::value,
      "a law that depends on the depth needs a sensor as first template argument, "
      "as pcl_ext::KinectV2: fov_x_deg, fov_y_deg, columns and rows");

  static constexpr IntensityUnit unit = LawT::unit;
  static constexpr bool uses_depth = LawT::uses_depth;
  static constexpr bool uses_native = LawT::uses_native;

  /** \brief A model of a sensor whose parameters are part of its type.
   * \param[in] resolution voxel edge d_v, metres, above 0
   */
  template <typename S = SensorT,
            typename = std::enable_if_t<std::is_default_constructible<S>::value>>
  explicit IntensityModel(double resolution) : IntensityModel(resolution, S{})
  {}

  /** \brief A model of a given sensor.
   * \param[in] resolution voxel edge d_v, metres, above 0
   * \param[in] sensor field of view and resolution
   * \param[in] law the law, if it has parameters
   */
  IntensityModel(double resolution, SensorT sensor, LawT law = LawT{})
  : sensor_(std::move(sensor)), law_(std::move(law)), resolution_(resolution)
  {
    if constexpr (uses_depth) {
      cut_off_depth_ = resolution / std::sqrt(pixelFootprint(sensor_));
      inverse_cut_off_depth_ = static_cast<float>(1.0 / cut_off_depth_);
    }
  }

  /** \brief The same sensor and law for another voxel edge, metres, above 0. */
  IntensityModel
  atResolution(double resolution) const
  {
    return IntensityModel(resolution, sensor_, law_);
  }

  /** \brief Point intensity I_p.
   * \param[in] depth along the optical axis in the sensor's frame, metres; below 0
   * counts as 0
   * \param[in] native the sensor's own intensity, in its unit
   */
  float
  operator()([[maybe_unused]] float depth, float native = 0.0f) const
  {
    if constexpr (uses_depth)
      return law_(std::clamp(depth * inverse_cut_off_depth_, 0.0f, 1.0f), native);
    else
      return law_(0.0f, native);
  }

  /** \brief N_p(z) = d_v^2 / (c z^2): the points that fit on a voxel face at a depth.
   * \param[in] depth metres, above 0
   */
  double
  pointsPerVoxelFace(double depth) const
  {
    static_assert(uses_depth, "this law does not depend on the sensor");
    const double relative_depth = depth / cut_off_depth_;
    return 1.0 / (relative_depth * relative_depth);
  }

  /** \brief z_c = d_v / sqrt(c): the depth, in metres, at which one point fills a voxel
   * face. Kinect V2 at 4 cm: 14.57 m. Infinite for a law that does not use depth. */
  double
  cutOffDepth() const
  {
    return cut_off_depth_;
  }

  /** \brief Voxel edge d_v, metres. */
  double
  resolution() const
  {
    return resolution_;
  }

  /** \brief Field of view and resolution of the sensor. */
  const SensorT&
  sensor() const
  {
    return sensor_;
  }

  /** \brief The law with its parameters. */
  const LawT&
  law() const
  {
    return law_;
  }

private:
  SensorT sensor_;
  LawT law_;
  double resolution_;
  double cut_off_depth_ = std::numeric_limits<double>::infinity();
  float inverse_cut_off_depth_ = 0.0f;
};

namespace detail {

template <typename ModelT, typename = void>
struct HasAtResolution : std::false_type {};

template <typename ModelT>
struct HasAtResolution<
    ModelT,
    std::void_t<decltype(std::declval<const ModelT&>().atResolution(1.0))>>
: std::true_type {};

/** \brief Exponent of the relative depth in a model's law; 0 if it has none. */
template <typename ModelT, typename = void>
struct DepthExponent : std::integral_constant<unsigned int, 0> {};

template <typename ModelT>
struct DepthExponent<ModelT, std::void_t<decltype(ModelT::Law::depth_exponent)>>
: std::integral_constant<unsigned int, ModelT::Law::depth_exponent> {};

} // namespace detail

/** \brief The model for another resolution: by its member atResolution() or, without
 * one, its constructor from a resolution; a model with neither is returned
 * unchanged. */
template <typename ModelT>
ModelT
modelAtResolution(const ModelT& model, [[maybe_unused]] double resolution)
{
  if constexpr (detail::HasAtResolution<ModelT>::value)
    return model.atResolution(resolution);
  else if constexpr (std::is_constructible<ModelT, double>::value)
    return ModelT(resolution);
  else
    return model;
}

/** \brief No intensity: for clouds of types without the field. In the published layout,
 * which always has intensities, voxels have the number of their points. */
struct NoIntensity {
  static constexpr IntensityUnit unit = IntensityUnit::None;
  static constexpr bool uses_depth = false;
  static constexpr bool uses_native = false;

  NoIntensity() = default;

  explicit NoIntensity(double /*resolution*/) {}

  float
  operator()(float /*depth*/, float /*native*/) const
  {
    return 1.0f;
  }
};

/** \brief Counts points, for any sensor. */
using CountIntensity = IntensityModel<UnspecifiedSensor, CountLaw>;

/** \brief Keeps the sensor's own intensity, for any sensor. */
using NativeIntensity = IntensityModel<UnspecifiedSensor, NativeLaw>;

namespace io {

/** \brief A law by which the intensity of a point depends on its depth in the sensor's
 * frame: full_intensity * (z / cut_off_depth)^exponent, full_intensity at most
 * (sections 2.5.2 and 2.5.3 of the paper). */
struct DepthLaw {
  /** \brief 1: linear; 2: quadratic. */
  unsigned int exponent = 2;

  /** \brief z_c, metres: the depth at which one point fills a voxel face; above 0. See
   * IntensityModel::cutOffDepth(). */
  double cut_off_depth = 0.0;

  /** \brief Intensity of a full voxel face, in the unit of the clouds' intensities;
   * above 0. */
  double full_intensity = 255.0;
};

} // namespace io

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

#pragma once

#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace pcl_ext {

namespace detail {

/** \brief Throws std::invalid_argument; where a program is built without exceptions, ends
 * it. */
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

/** \brief A sensor whose figures are known only when the program runs, for example from
 * a parameter file. */
struct RuntimeSensor {
  /** \brief Takes and checks the figures of a sensor.
   * \param[in] horizontal_fov_deg horizontal field of view, degrees, in (0, 180)
   * \param[in] vertical_fov_deg vertical field of view, degrees, in (0, 180)
   * \param[in] image_columns width of the depth image, pixels, above 0
   * \param[in] image_rows height of the depth image, pixels, above 0
   * \throws std::invalid_argument if a figure is outside its range
   */
  RuntimeSensor(double horizontal_fov_deg,
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
        detail::throwInvalidArgument(
            "field of view must lie between 0 and 180 degrees, "
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

/** \brief Stands in where an intensity law asks nothing of the sensor (count, native).
 */
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

} // namespace pcl_ext

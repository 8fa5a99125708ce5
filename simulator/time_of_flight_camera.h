// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The rays of a Kinect V2 and the errors of its depth measurement.
 *
 * Sources. Of the articles only the abstracts were available, except where stated.
 *
 * [F] P. Fankhauser, M. Bloesch, D. Rodriguez, R. Kaestner, M. Hutter, R. Siegwart,
 *     "Kinect v2 for Mobile Robot Navigation: Evaluation and Modeling", ICAR 2015, pp.
 *     388-394, doi 10.1109/ICAR.2015.7251485. Axial noise indoors, z in metres, theta
 *     the angle of the surface:
 *     sigma = 1.5 - 0.5 z + 0.3 z^2 + 0.1 z^(3/2) theta^2 / (pi/2 - theta)^2 mm.
 *     Checked against two public programs that quote the paper's formula alike. It is
 *     used here for all depths up to 13 m, further than it was fitted.
 * [C] A. Corti, S. Giancola, G. Mainetti, R. Sala, "A metrological characterization of
 *     the Kinect V2 time-of-flight camera", Robotics and Autonomous Systems 75, 2016,
 *     pp. 584-594. "The casual uncertainty increases with the depth and the radial
 *     coordinate"; a point's uncertainty is 1.5 to tens of millimetres.
 * [J] F. Järemo Lawin, P.-E. Forssén, H. Ovrén, "Efficient Multi-Frequency Phase
 *     Unwrapping using Kernel Density Estimation", ECCV 2016, LNCS 9908, pp. 170-185.
 *     The sensor is meant for scenes within 8 m; its largest depth is 18.75 m.
 * [W] O. Wasenmüller, D. Stricker, "Comparison of Kinect v1 and v2 Depth Images in
 * Terms
 *     of Accuracy and Precision", ACCV 2016 Workshops, pp. 34-45. Shows flying pixels at
 *     depth edges. No value taken.
 *
 * Everything else in \ref ErrorModel is a free parameter and documented as such.
 */
#pragma once

#include "simulator/random_numbers.h"
#include "simulator/shapes.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace cell {

/** \brief Where a point of a frame comes from. */
enum class PointTruth : std::uint8_t {
  None,        ///< no return; the point is NaN
  Surface,     ///< a surface, with its axial noise
  FlyingPixel, ///< a mixture of two surfaces on either side of a depth edge
  Speckle,     ///< nothing at all: a random return at short range
  Snow,        ///< a flake in the air
  Dust         ///< a cloud of dust
};

/** \brief The image that the sensor would see without errors, row by row. */
struct SurfaceImage {
  /** \brief An image of nothing. */
  explicit SurfaceImage(std::size_t pixels = 0)
  : depth(pixels, 0.0f)
  , cos_incidence(pixels, 1.0f)
  , material(pixels, Material::Concrete)
  {}

  /** \brief Draws a pixel, unless what it shows is nearer, or nothing was hit.
   * \return true if it was drawn
   */
  bool
  drawInFront(std::size_t pixel,
              float pixel_depth,
              double pixel_cos_incidence,
              Material pixel_material)
  {
    const float behind = depth[pixel];
    if (pixel_depth <= 0.0f || (behind > 0.0f && behind <= pixel_depth))
      return false;
    depth[pixel] = pixel_depth;
    cos_incidence[pixel] = static_cast<float>(pixel_cos_incidence);
    material[pixel] = pixel_material;
    return true;
  }

  std::vector<float> depth;         ///< metres along the optical axis; 0: nothing hit
  std::vector<float> cos_incidence; ///< cosine of the angle of incidence
  std::vector<Material> material;
};

/** \brief Rays evenly spaced on the image plane: 512 x 424 over 70.6 x 60 degrees, as
 * in the paper's traits of the Kinect V2. */
class RayGrid {
public:
  static constexpr std::size_t columns = 512;
  static constexpr std::size_t rows = 424;
  static constexpr std::size_t size = columns * rows;

  RayGrid();

  /** \brief x at depth 1 of a column's rays, to the right. */
  double
  x(std::size_t column) const
  {
    return x_[column];
  }

  /** \brief y at depth 1 of a row's rays, down. */
  double
  y(std::size_t row) const
  {
    return y_[row];
  }

  /** \brief Draw solids into an image, in front of what it holds behind them.
   * \param[out] changed indices of the pixels that were drawn on, each possibly more
   * than once; may be null
   */
  void
  trace(const Solids& solids,
        const Eigen::Isometry3d& world_to_sensor,
        SurfaceImage& image,
        std::vector<std::size_t>* changed) const;

private:
  template <typename TargetT>
  void
  traceTarget(const TargetT& target,
              Material material,
              SurfaceImage& image,
              std::vector<std::size_t>* changed) const;

  std::vector<double> x_;
  std::vector<double> y_;
};

/** \brief Error of the measurement of a surface at one pixel. */
struct PixelError {
  float sigma = 0.0f;     ///< standard deviation of the axial noise, metres
  std::uint32_t loss = 0; ///< probability of no return, in units of 2^-32
};

/** \brief One measured depth image. */
struct Measurement {
  std::vector<std::uint16_t> depth; ///< millimetres; 0: no return
  std::vector<PointTruth> truth;
};

/** \brief The error model; its defaults are the simulator's. */
struct ErrorModel {
  /** \brief Growth of the axial noise from the image centre (factor 1) to the corners
   * (factor 1 + this), quadratic in between. [C] says that it grows; the amount is a
   * free parameter. */
  double corner_noise_growth = 0.5;

  /** \brief Axial noise in place of [F]'s: a + b depth + c depth^2, millimetres, with the
   * depth in metres; all 0: [F]'s. */
  std::array<double, 3> depth_noise{};

  /** \brief Angle of incidence above which [F]'s growth with the angle is held, since
   * it has a pole at 90 degrees. Radians; free parameter. */
  double steepest_modelled_angle = 1.22;

  /** \brief Returned signal, reflectivity * cos(incidence) / depth^2 in 1/m^2, above
   * which nothing is lost and below which everything is; smooth in between. Free
   * parameters: they let light, head-on surfaces through beyond the 8 m of [J] with
   * growing losses, and lose dark and grazed ones earlier. */
  double safe_signal = 0.0080;
  double lost_signal = 0.0012;

  /** \brief Depth step between neighbouring pixels that counts as an edge: the larger
   * of these, metres and share of the depth. Free parameters. */
  double edge_step = 0.10;
  double edge_step_share = 0.03;

  /** \brief Share of the edge pixels that come back as flying pixels ([W]) rather than
   * as one of the surfaces; drivers filter some. Free parameter. */
  double flying_share = 0.6;

  /** \brief Scatter of a flying pixel from frame to frame, as a share of the step that
   * it hangs in. Free parameter. */
  double flying_scatter = 0.05;

  /** \brief Probability that a pixel without a return yields a random one, and the
   * depth range of those, metres. Free parameters. */
  double speckle_probability = 0.006;
  double speckle_nearest = 0.5;
  double speckle_farthest = 3.0;

  /** \brief Axial noise of [F] in metres.
   * \param[in] depth metres
   * \param[in] incidence angle between ray and surface normal, radians
   */
  static double
  axialNoise(double depth, double incidence);

  /** \brief Errors of a surface seen at (x, y, 1). */
  PixelError
  pixelError(const RayGrid& rays,
             const SurfaceImage& surfaces,
             std::size_t pixel) const;

  /** \brief Measure an image once.
   * \param[in] errors one per pixel
   * \param[in] frame_seed seed of the frame's random numbers
   * \param[in] sensor_seed seed of what stays the same in all frames of a sensor: which
   * side of an edge is mixed, and in which proportion
   */
  void
  measure(const SurfaceImage& surfaces,
          const std::vector<PixelError>& errors,
          std::uint32_t frame_seed,
          std::uint32_t sensor_seed,
          Measurement& measurement) const;
};

} // namespace cell
} // namespace pcl_ext

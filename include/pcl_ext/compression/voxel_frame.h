// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/impl/depth_model.h>
#include <pcl_ext/compression/impl/saturated_float.h>
#include <pcl_ext/compression/message_layout.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/export.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief Lowest number of a level of a companded scale.
 *
 * The numbers 0..range are divided into 2^bits levels of at least one number each. With
 * 8 levels or more the levels 0..3 are the single numbers 0..3, and level 4 begins at
 * 4; further levels become wider in proportion to the square root of the number, as the
 * noise of a count does:
 *
 *     edge(4 + j) = 4 + j + (range - 3 - n) * j^2 / n^2,  n = 2^bits - 4,  j = 0..n
 *
 * rounded down. Four levels begin at 0, 1, 2, 4 and two at 0, 1. For counts from 1 on
 * (number = count - 1) the decisions "at least 2, 3, 4, 5 points" are thus exact with 3
 * bits or more, and "at least 2, 3, 5" with 2. Integer arithmetic only, so that all
 * machines compute the same edges.
 *
 * \param[in] bits 1..15
 * \param[in] range the highest number, 2^bits..65535
 * \param[in] level 0..2^bits; 2^bits gives the end of the last level
 * \return a number, 0..range + 1, strictly ascending with the level
 */
PCL_EXT_CODEC_EXPORT std::uint32_t
compandedEdge(unsigned int bits, std::uint32_t range, std::uint32_t level);

/** \brief The number that a level is decoded as: the middle of its numbers, rounded
 * down.
 *
 * It is within the level, so that a comparison "intensity >= threshold" has the same
 * result before and after coding if the threshold is the edge of a level.
 *
 * \param[in] bits 1..15
 * \param[in] range the highest number, 2^bits..65535
 * \param[in] level 0..2^bits - 1
 */
PCL_EXT_CODEC_EXPORT std::uint32_t
compandedMiddle(unsigned int bits, std::uint32_t range, std::uint32_t level);

/** \brief How a voxel intensity becomes a symbol of 1 to 16 bits and back: intensity =
 * offset + number * step.
 *
 * On a linear scale the symbol is the number. On a companded one it is the level that
 * contains the number, and is decoded as the level's middle number; see compandedEdge.
 */
struct IntensityScale {
  float offset = 0.0f;   ///< intensity of number 0
  float step = 1.0f;     ///< intensity from one number to the next, above 0
  unsigned int bits = 8; ///< symbols are below 2^bits; 1..16, or 0: no intensities

  /** \brief The highest number of a companded scale, 2^bits..65535; 0: a linear
   * scale. */
  std::uint32_t companded_range = 0;

  /** \brief The highest symbol. */
  std::uint32_t
  maxSymbol() const
  {
    return (std::uint32_t{1} << bits) - 1;
  }

  /** \brief The highest number. */
  std::uint32_t
  maxNumber() const
  {
    return companded_range != 0 ? companded_range : maxSymbol();
  }

  /** \brief Intensity of a symbol, clamped to the range of float. */
  float
  value(std::uint16_t symbol) const
  {
    const std::uint32_t number =
        companded_range != 0 ? compandedMiddle(bits, companded_range, symbol) : symbol;
    // The top of a scale may be outside the range of float due to rounding.
    return pcl_ext::detail::saturatedFloat(static_cast<double>(offset) +
                                           static_cast<double>(number) *
                                               static_cast<double>(step));
  }

  bool
  operator==(const IntensityScale& other) const
  {
    return offset == other.offset && step == other.step && bits == other.bits &&
           companded_range == other.companded_range;
  }

  bool
  operator!=(const IntensityScale& other) const
  {
    return !(*this == other);
  }
};

/** \brief Colour of a voxel; its channels are below 2^colour_bits of the frame. */
struct VoxelColour {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;

  bool
  operator==(const VoxelColour& other) const
  {
    return r == other.r && g == other.g && b == other.b;
  }
};

/** \brief A lidar that turns about an axis, as its points tell it. */
struct SpinningSensor {
  std::array<double, 3> origin{}; ///< from the grid's lowest corner, voxels
  std::array<double, 3> up{};     ///< unit vector along the axis
  double azimuth_step = 0.0;      ///< usual angle between columns, radians
  double elevation_step = 0.0;    ///< usual angle between rows, radians
};

/** \brief The points of a frame one by one, where a stream keeps the order of their
 * sensor. Each coordinate is within half an edge of what it was. */
struct FramePoints {
  std::uint32_t width = 0;  ///< columns of a decoded cloud; 0: there are only voxels
  std::uint32_t height = 0; ///< its rows; with one it has no missing points
  /** \brief Where each point is in a decoded cloud, row * width + column: ascending, or
   * in a frame with voxels in their order and ascending within each of them. */
  std::vector<std::uint32_t> indices;
  std::vector<std::array<double, 3>> positions; ///< world coordinates, metres
  /** \brief Of each point a symbol of the frame's scale; empty without intensities. */
  std::vector<std::uint16_t> intensities;
  std::vector<VoxelColour> colours; ///< one of each point; empty without colours
  std::optional<SpinningSensor> sensor;
  /** \brief Points that were outside the grid and were left out, when the others got
   * voxels. A scan reaches as far as its points, a grid at most 2^21 voxels. */
  std::size_t outside_grid = 0;
  /** \brief Where these were in a cloud of one row, which has no place for them any more:
   * ascending; else empty. */
  std::vector<std::uint32_t> left_out;
  /** \brief Whether floats do not hold all positions to 1/16 of an edge, as some are
   * further from the world's origin than 2^20 edges. */
  bool need_doubles = false;

  /** \brief Whether a frame has its points. */
  bool
  areThere() const
  {
    return width > 0;
  }

  /** \brief Points of a decoded cloud, with those that are missing. */
  std::size_t
  cloudSize() const
  {
    return std::size_t{width} * height;
  }
};

/** \brief Farthest position of a viewpoint from the grid's lowest voxel, voxels. */
constexpr std::int32_t farthest_viewpoint = 1 << 22;

/** \brief One frame of a stream: the occupied voxels of a grid, and for each what the
 * stream has of its intensity, colour and number of points. */
struct VoxelFrame {
  VoxelGrid grid;
  IntensityScale intensity_scale;        ///< bits 0: no intensities
  std::optional<DepthModel> depth_model; ///< where intensities depend on depth
  unsigned int colour_bits = 0;          ///< of a channel, 1..8; 0: no colours
  bool has_point_counts = false;
  std::vector<std::uint64_t> keys; ///< Morton keys, strictly ascending
  /** \brief A symbol of intensity_scale for each key; empty without intensities. */
  std::vector<std::uint16_t> intensities;
  std::vector<VoxelColour> colours;        ///< one for each key; empty without colours
  std::vector<std::uint32_t> point_counts; ///< likewise; 1 or more

  /** \brief Further fields of the points, or without numbers of points of the
   * voxels. */
  std::vector<FrameField> fields;
  /** \brief Position of the sensor in the grid, voxels from its lowest one, -2^22 to
   * 2^22, for the prediction of fields. */
  std::array<std::int32_t, 3> viewpoint{};

  /** \brief The points, if the stream has the order of their sensor. Such a frame may be
   * without voxels, see FrameDecoder::setDecodesVoxels(). */
  FramePoints points;

  /** \brief How the messages are laid out that the stream is made of; null: it does not
   * tell. */
  std::shared_ptr<const MessageLayout> layout;

  /** \brief Whether voxels have intensities. */
  bool
  hasIntensities() const
  {
    return intensity_scale.bits > 0;
  }

  /** \brief A colour in channels of 0 to 255; the frame has to have colours. */
  VoxelColour
  fullColour(const VoxelColour& colour) const
  {
    const unsigned int highest = (1u << colour_bits) - 1;
    const auto full = [highest](unsigned int channel) {
      return static_cast<std::uint8_t>((2 * 255 * channel + highest) / (2 * highest));
    };
    return {full(colour.r), full(colour.g), full(colour.b)};
  }

  /** \brief The same of a voxel. */
  VoxelColour
  fullColour(std::size_t voxel) const
  {
    return fullColour(colours[voxel]);
  }

  /** \brief Number of points: one for each voxel, or as many as it had. */
  std::size_t
  pointCount() const
  {
    if (points.areThere())
      return points.indices.size();
    std::size_t count = 0;
    for (const std::uint32_t of_voxel : point_counts)
      count += of_voxel;
    return has_point_counts ? count : size();
  }

  /** \brief Whether a decoded cloud has rows and columns. */
  bool
  isOrganised() const
  {
    return points.height > 1;
  }

  /** \brief Number of points of a decoded cloud, some of which are not a number if it has
   * rows and columns. */
  std::size_t
  cloudSize() const
  {
    return points.areThere() ? points.cloudSize() : pointCount();
  }

  /** \brief Whether no point of a decoded cloud is missing. */
  bool
  isDense() const
  {
    return !points.areThere() || points.indices.size() == points.cloudSize();
  }

  /** \brief Where a point is in a decoded cloud.
   * \param[in] point in the order of forEachPoint(), below pointCount()
   */
  std::size_t
  cloudIndex(std::size_t point) const
  {
    return points.areThere() ? points.indices[point] : point;
  }

  /** \brief Columns of a decoded cloud. */
  std::size_t
  cloudWidth() const
  {
    return points.areThere() ? points.width : pointCount();
  }

  /** \brief Rows of a decoded cloud. */
  std::uint32_t
  cloudHeight() const
  {
    return points.areThere() ? points.height : 1;
  }

  /** \brief Number of values of all fields. */
  std::size_t
  fieldValueCount() const
  {
    std::size_t values = 0;
    for (const FrameField& field : fields)
      values += field.numbers.size();
    return values;
  }

  /** \brief Number of occupied voxels. */
  std::size_t
  size() const
  {
    return keys.size();
  }

  /** \brief Whether decoded clouds have coordinates in double precision. */
  bool
  needsDoubles() const
  {
    return grid.needsDoubles() || points.need_doubles;
  }

  /** \brief Removes all voxels and points. */
  PCL_EXT_CODEC_EXPORT void
  clearVoxels();
};

/** \brief True if a frame is valid: keys strictly ascending and within the grid, as
 * many intensities, colours and numbers of points as keys or none, all of them and all
 * parameters within their ranges; points, if there are any, as many as all voxels have.
 * Encoders refuse a frame that is not. They take its voxels, not its points. */
PCL_EXT_CODEC_EXPORT bool
isConsistent(const VoxelFrame& frame);

/** \brief The fields of a cloud's header that a frame may contain. */
struct FrameStamp {
  std::uint64_t stamp = 0; ///< time of the frame, microseconds in PCL; 0: none
  std::string frame_id;    ///< of the coordinates, 1024 bytes at most; empty: none
};

/** \brief Calls a function for each voxel of a frame, in the order of the keys.
 *
 * Gives VoxelGrid::centre and IntensityScale::value, rounded to float, faster than
 * these. Far from the world's origin see forEachPreciseCentre(). Colours and numbers of
 * points are those of the same place in the order of the keys.
 * \code
 * io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
 *   cloud.push_back({x, y, z, intensity});
 * });
 * \endcode
 * \param[in] frame as isConsistent() demands; must not change meanwhile. With a
 * companded scale of more than 8 bits memory is allocated
 * \param[in] visit callable as visit(x, y, z, intensity): the voxel's centre in world
 * coordinates, metres, and its intensity in the unit of the frame's scale; 0 without
 * intensities
 */
template <typename VisitT>
void
forEachVoxelCentre(const VoxelFrame& frame, VisitT&& visit);

/** \brief The same with visit(double, double, double, float) where
 * VoxelFrame::needsDoubles(); else with visit(float, float, float, float), as above. For
 * decoded clouds that may have either type of coordinates.
 */
template <typename VisitT>
void
forEachPreciseCentre(const VoxelFrame& frame, VisitT&& visit);

/** \brief Calls a function for each point of a decoded cloud that is not missing: at the
 * centre of each voxel as many as it had, or where they are in a frame that has its
 * points. Values of fields are in the same order.
 * \param[in] frame as isConsistent() demands, or without voxels if it has its points
 * \param[in] visit callable as visit(std::size_t point, x, y, z, float intensity, const
 * VoxelColour& colour), with the coordinates of forEachPreciseCentre(): see cloudIndex()
 * for where the point is; the intensity is in the unit of the frame's scale, 0 without
 * intensities; channels are 0 to 255, all of them 255 without colours
 */
template <typename VisitT>
void
forEachPoint(const VoxelFrame& frame, VisitT&& visit);

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io

#include <pcl_ext/compression/impl/voxel_centres.hpp>

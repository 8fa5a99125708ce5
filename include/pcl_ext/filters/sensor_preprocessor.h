// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/export.h>
#include <pcl_ext/filters/impl/moved_points.hpp>
#include <pcl_ext/impl/point_intensity.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/point_types.h>
#include <pcl_ext/status.h>

#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup filters
 * @{ */

/** \brief Outcome codes of preprocessing. */
enum class PreprocessingCode {
  Ok,              ///< the cloud was processed
  InvalidSettings, ///< invalid pose, crop box or scale
  MissingField,    ///< x, y, z, or the intensity that the model needs, is missing
  InvalidField,    ///< a field has an invalid datatype, offset or count
  InvalidLayout    ///< width, height and steps do not fit the bytes
};

/** \brief Outcome of preprocessing a cloud. */
using PreprocessingStatus = Status<PreprocessingCode>;

/** \brief Counts of the points of a cloud, and whether they have colours. */
struct PreprocessingStatistics {
  std::size_t points = 0; ///< points of the input
  std::size_t points_not_finite =
      0;                          ///< of these left out: not finite, or not when moved
  std::size_t points_cropped = 0; ///< of these left out: outside the crop box
  /** \brief Of the points that were kept: of negative depth, whose intensity is
   * therefore 0; counted by models that use the depth. */
  std::size_t points_behind_sensor = 0;
  bool has_colours = false; ///< colours were read; else those of the output are black
};

/** \brief Datatypes of pcl::PCLPointField, of x, y and z. */
using CoordinateTypes = std::array<std::uint8_t, 3>;

/** \brief True for one type of real numbers, FLOAT32 or FLOAT64. */
PCL_EXT_EXPORT bool
areReal(const CoordinateTypes& types);

/** \brief Whether floats have not each value of all types, so that coordinates are read
 * as doubles. */
PCL_EXT_EXPORT bool
needDoubles(const CoordinateTypes& types);

/** \brief What coordinates are taken as that are whole numbers, or of several types;
 * empty if areReal(). */
PCL_EXT_EXPORT std::string
describeCoordinates(const CoordinateTypes& types);

/** \brief Offsets of the fields of a PCLPointCloud2, checked against its size. */
struct PointLayout {
  std::uint32_t x = 0; ///< offsets within a point, bytes
  std::uint32_t y = 0;
  std::uint32_t z = 0;
  CoordinateTypes types{};
  bool is_double = false; ///< see needDoubles()
  bool has_intensity = false;
  std::uint32_t intensity = 0;
  std::uint8_t intensity_datatype = 0; ///< of pcl::PCLPointField
  bool has_colour = false;
  std::uint32_t colour = 0; ///< 32 bits as PCL's field rgba, whatever the datatype
};

/** \brief Bytes from a row of a cloud to the next one. Some drivers leave row_step at 0,
 * or at that of an image from which the cloud was cut: where the data are exactly the
 * points, rows are without gaps, whatever row_step says; a single row that is longer than
 * row_step ends with its last point. */
PCL_EXT_EXPORT std::size_t
rowStep(const pcl::PCLPointCloud2& cloud);

/** \brief True if a cloud has a field of that name whose number can be read: of a known
 * datatype, alone, and within the point. */
PCL_EXT_EXPORT bool
hasReadableField(const pcl::PCLPointCloud2& cloud, const std::string& name);

/** \brief Finds x, y, z, intensity and colour in a cloud by name and datatype. The
 * colour is the field `rgb`, else `rgba`, FLOAT32, UINT32 or INT32; fields of other
 * types, or beyond the point, are none.
 * \param[in] cloud any fields in any order, organised or not
 * \param[in] intensity_field name of the intensity field
 * \param[in] needs_intensity a cloud without that field is an error
 * \param[in] reads_colour the colour is looked for; a cloud without is no error
 * \param[out] layout the offsets; every point's fields are within cloud.data
 */
PCL_EXT_EXPORT PreprocessingStatus
findPointLayout(const pcl::PCLPointCloud2& cloud,
                const std::string& intensity_field,
                bool needs_intensity,
                bool reads_colour,
                PointLayout& layout);

/** \brief A field of a PCLPointCloud2. */
struct FoundField {
  io::FieldDescription description; ///< exact
  std::uint32_t offset = 0;         ///< within a point, bytes
};

/** \brief Finds the fields of a cloud but x, y, z and the gaps that are called "_".
 * Those of other datatypes than the eight of io::FieldType, and those that are not within
 * a point, are left out. */
PCL_EXT_EXPORT std::vector<FoundField>
findFields(const pcl::PCLPointCloud2& cloud);

/** \brief Prepares a sensor's cloud for compression: removes points that are not
 * finite, computes intensities, and transforms and crops the cloud in the global
 * coordinate frame, in one pass over the points (sections 2.2 and 2.5 of the paper).
 *
 * The intensity is taken from the depth in the sensor's frame, before the point is
 * moved. An output type with a colour gets that of the input, if it has one.
 * \tparam IntensityModelT see IntensityModel for the contract
 * \tparam OutputPointT type of the processed points: pcl::PointXYZI; PointXYZRGBI for
 * coloured clouds; or another type of 32 bytes that begins with PCL_ADD_POINT4D
 */
template <typename IntensityModelT, typename OutputPointT = pcl::PointXYZI>
class SensorPreprocessor {
public:
  using Output = pcl::PointCloud<OutputPointT>;

  /** \brief A preprocessor that neither moves nor crops.
   * \param[in] intensity_model intensity of one point
   */
  explicit SensorPreprocessor(const IntensityModelT& intensity_model)
  : intensity_model_(intensity_model)
  {}

  /** \brief Pose of the sensor, sensor -> global coordinate frame, metres; must be
   * rigid, which process() checks. */
  void
  setSensorPose(const Eigen::Isometry3d& sensor_to_world)
  {
    sensor_pose_ = sensor_to_world;
  }

  /** \brief Keeps only points within a box of the global coordinate frame, metres, both
   * ends included; min <= max on each axis. */
  void
  setCropBox(const Eigen::Vector3d& min, const Eigen::Vector3d& max)
  {
    crop_box_ = CropBox{min, max};
  }

  /** \brief Keeps all points again. */
  void
  clearCropBox()
  {
    crop_box_.reset();
  }

  /** \brief Factor on the model's intensity, above 0; 255 gives shares of a voxel face
   * the scale of the published layout. 1 by default. */
  void
  setIntensityScale(float scale)
  {
    intensity_scale_ = scale;
  }

  /** \brief Name of the field that a native model reads; "intensity" by default.
   * Applies to PCLPointCloud2. */
  void
  setIntensityField(const std::string& name)
  {
    intensity_field_ = name;
  }

  /** \brief Whether an output type with a colour gets the colours of the input, which
   * it does by default. */
  void
  setReadsColours(bool reads_colours)
  {
    reads_colours_ = reads_colours && has_colour_field<OutputPointT>;
  }

  /** \brief Processes a cloud whose fields are found by name and datatype.
   *
   * Coordinates that need doubles are moved and cropped as such, and so are those of a
   * sensor more than 1024 m from the origin of the global coordinate frame. In the
   * output they are rounded to PCL's float; PreprocessedBatches has them as they are.
   * \param[in] cloud x, y, z of any datatypes but BOOL, metres, see
   * describeCoordinates(); intensity of any datatype if the model is native, rgb or
   * rgba as FLOAT32 or UINT32 if colours are read; further fields are ignored
   * \param[out] output intensity I_p times the scale; colours as the input's, or black
   * if it has none; header as the input's, sensor origin and orientation as the
   * sensor's pose; empty unless the status is Ok
   */
  PreprocessingStatus
  process(const pcl::PCLPointCloud2& cloud, Output& output);

  /** \brief The same for a typed cloud.
   * \param[in] cloud points with x, y, z; may be the output itself
   * \param[out] output as above
   */
  template <typename PointT>
  PreprocessingStatus
  process(const pcl::PointCloud<PointT>& cloud, Output& output);

  /** \brief Counts of the points of the last cloud. */
  const PreprocessingStatistics&
  statistics() const
  {
    return statistics_;
  }

private:
  struct CropBox {
    Eigen::Vector3d min;
    Eigen::Vector3d max;
  };

  using DoublePoint = std::array<double, 3>;

  PreprocessingStatus
  checkSettings() const;

  PreprocessingStatus
  start(const pcl::PCLPointCloud2& cloud, PointLayout& layout);

  void
  startOutput(const pcl::PCLHeader& header, Output& output);

  void
  startPoints(std::size_t points, bool has_colours);

  template <typename MoveChunkT>
  void
  addChunks(std::size_t count, const MoveChunkT& move_chunk, Output& output);

  std::size_t
  readChunk(const pcl::PCLPointCloud2& cloud,
            const PointLayout& layout,
            std::size_t row,
            std::size_t column,
            std::size_t most,
            OutputPointT* results,
            DoublePoint* doubles);

  bool
  movesDoubles(const PointLayout& layout) const;

  template <typename NativeOfT, typename ColourOfT>
  std::size_t
  moveChunk(const detail::PointBytes& points,
            const NativeOfT& native_of,
            const ColourOfT& colour_of,
            OutputPointT* results);

  template <typename PointOfT, typename NativeOfT, typename ColourOfT>
  std::size_t
  gatherChunk(std::size_t count,
              const PointOfT& point_of,
              const NativeOfT& native_of,
              const ColourOfT& colour_of,
              OutputPointT* results);

  template <typename PointOfT, typename NativeOfT, typename ColourOfT>
  std::size_t
  moveDoubles(std::size_t count,
              const PointOfT& point_of,
              const NativeOfT& native_of,
              const ColourOfT& colour_of,
              OutputPointT* results,
              DoublePoint* doubles);

  /** \brief Sets intensities and colours of moved points, and counts the points left
   * out.
   * \param[in] count points before the move
   */
  template <typename NativeOfT, typename ColourOfT>
  void
  finishChunk(std::size_t count,
              const detail::MovedPoints& moved,
              const NativeOfT& native_of,
              const ColourOfT& colour_of,
              OutputPointT* results);

  void
  finishOutput(Output& output) const;

  template <typename ModelT, typename PointT>
  friend class PreprocessedBatches;

  IntensityModelT intensity_model_;
  Eigen::Isometry3d sensor_pose_ = Eigen::Isometry3d::Identity();
  std::optional<CropBox> crop_box_;
  float intensity_scale_ = 1.0f;
  std::string intensity_field_ = "intensity";
  bool reads_colours_ = has_colour_field<OutputPointT>;
  PreprocessingStatistics statistics_;
  /** \brief Where the indices in a chunk of the points that were kept are appended;
   * null: nowhere. */
  std::vector<std::uint32_t>* sources_ = nullptr;

  // Of the current cloud.
  detail::PointMove move_{};
  std::size_t kept_ = 0; // points of the output that are valid
  Output input_;         // the points of a cloud that is its own output
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

#include <pcl_ext/filters/impl/sensor_preprocessor.hpp>

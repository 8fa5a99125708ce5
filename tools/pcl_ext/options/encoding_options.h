// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/sensor_node.h>

#include "clouds/usual_fields.h"
#include "inputs/stream_metadata.h"
#include "options/options.h"
#include "options/text_values.h"

#include <CLI/App.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

/** \brief Adds --remove-outliers, and --unit, which needs it. */
void
addOutlierRemoval(CLI::App& app,
                  const std::string& description,
                  bool& removes_outliers,
                  const std::string& unit_description,
                  DensityUnit& unit);

/** \brief Defaults for the clouds of the simulated robot cell: metres, and the law with
 * which noise is told from surfaces. */
constexpr double cell_resolution = 0.04;
constexpr IntensityLaw cell_law = IntensityLaw::Count;

/** \brief Default of what writes files, which are encoded once and kept. What sends has
 * that of the library. */
constexpr io::Effort effort_of_files = io::Effort::Balanced;

class EncodingOptions {
public:
  /** \brief Other defaults than those of the library, before options are added.
   * \param[in] resolution metres
   * \param[in] law of a point
   */
  void
  setDefaults(double resolution, IntensityLaw law)
  {
    codec_.resolution = resolution;
    law_ = law;
  }

  /** \brief Removes outliers by the intensities of a law. */
  void
  removeOutliersBy(IntensityLaw law)
  {
    removes_outliers_ = true;
    law_ = law;
  }

  /** \brief Adds resolution, law, effort and the other settings of the codec. */
  void
  addCodecOptions(CLI::App& app);

  /** \brief Adds what concerns the clouds: pose, crop box, outliers. */
  void
  addCloudOptions(CLI::App& app);

  /** \brief Adds --max-rate and what belongs to it. */
  void
  addBudget(CLI::App& app);

  /** \brief Adds --crop, which addCloudOptions() has, too. */
  void
  addCropOption(CLI::App& app);

  /** \brief Checks all settings against their ranges and each other, and refuses
   * options that have no effect.
   * \throws UsageError
   */
  void
  check() const;

  /** \brief Refuses --frame-id where nothing tells it.
   * \param[in] has_messages the output has messages, which have a frame_id
   * \throws UsageError
   */
  void
  checkFrameId(bool has_messages) const;

  /** \brief The law of a cloud; automatic: native if it has an intensity that is not
   * kept as a further field, else none. */
  IntensityLaw
  lawOf(const pcl::PCLPointCloud2& cloud) const;

  /** \brief The settings of the node of a stream.
   * \param[in] law that of its clouds
   * \param[in] frame_id that of its clouds; none: they have no such name, or a pose
   */
  nodes::SensorNodeSettings
  nodeSettings(IntensityLaw law, const std::optional<std::string>& frame_id) const;

  /** \brief Checks the streams that options name.
   * \param[in] streams their names
   * \throws UsageError if there is no such stream
   */
  void
  checkStreams(const std::vector<std::string>& streams) const;

  /** \brief Pose of a stream's sensor, or the identity. */
  WorldPose
  poseOf(const std::string& stream) const;

  /** \brief True if a stream's clouds are moved by a pose. */
  bool
  hasPose(const std::string& stream) const;

  /** \brief What a recording keeps of a stream's settings that frames do not have: the
   * law, and the pose if there is one. */
  StreamMetadata
  metadataOf(const std::string& stream, IntensityLaw law, bool is_of_lidar) const;

  const io::EncoderSettings&
  codec() const
  {
    return codec_;
  }

  /** \brief The same to be changed; before options are added what it has are their
   * defaults. */
  io::EncoderSettings&
  codec()
  {
    return codec_;
  }

  /** \brief Sets crop box and sensor of the simulated robot cell, unless options give
   * them. */
  void
  completeForCell();

  const std::optional<io::BoundingBox>&
  cropBox() const
  {
    return crop_box_;
  }

  /** \brief Sets the pose of a stream's sensor. */
  void
  setPose(const std::string& stream, const WorldPose& pose)
  {
    poses_.emplace_back(stream, pose);
  }

  bool
  removesOutliers() const
  {
    return removes_outliers_;
  }

  const std::optional<IntensityLaw>&
  law() const
  {
    return law_;
  }

  /** \brief Whether --frame-id names the coordinate frame of all clouds. */
  bool
  namesFrame() const
  {
    return !frame_id_.empty();
  }

  /** \brief What becomes of fields of 64-bit integers of files. */
  clouds::LongIntegers
  longIntegers() const;

  /** \brief Whether a field of a cloud is kept, by its name or as one of all. */
  bool
  keepsField(const std::string& name) const;

  /** \brief Name of the field that the law native reads. */
  std::string
  intensityField() const
  {
    return intensity_field_.empty() ? "intensity" : intensity_field_;
  }

private:
  /** \brief Whether a cloud's intensity is a further field, whose values decoding gives
   * in place of those of voxels, and no option asks for these. */
  bool
  keepsIntensityAsField(const pcl::PCLPointCloud2& cloud) const;

  void
  checkEffects() const;

  /** \brief Refuses options that have no effect without a limit. */
  void
  checkBudget() const;

  const CLI::App* app_ = nullptr; // to which the options were added
  io::EncoderSettings codec_;
  bool has_budget_ = false; // the options have one
  bool carries_header_ = true;
  std::optional<IntensityLaw> law_; ///< none: automatic
  std::optional<RuntimeSensor> sensor_;
  std::optional<io::BoundingBox> crop_box_;
  /** \brief By stream; that of the empty name is for all others. */
  std::vector<std::pair<std::string, WorldPose>> poses_;
  std::string frame_id_;        ///< empty: that of the clouds
  std::string intensity_field_; // empty: the default
  bool removes_outliers_ = false;
  DensityUnit unit_ = DensityUnit::Automatic;
};

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "clouds/file_text.h"
#include "clouds/usual_fields.h"
#include "simulator/robot_cell.h"

#include <pcl/PCLPointCloud2.h>

#include <Eigen/Geometry>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief Clouds of one sensor in time order. */
class CloudSequence {
public:
  explicit CloudSequence(std::string name) : name_(std::move(name)) {}
  virtual ~CloudSequence() = default;

  /** \brief Name for tables and folders. */
  const std::string&
  name() const
  {
    return name_;
  }

  void
  rename(const std::string& name)
  {
    name_ = name;
  }

  /** \brief What may be wrong with the clouds, a line for the user; empty if nothing. */
  virtual std::string
  remark() const
  {
    return {};
  }

  /** \brief What of the clouds that were read is left out, or taken otherwise than it
   * is in their files, a line each. */
  virtual std::vector<std::string>
  remarksOnClouds() const
  {
    return {};
  }

  virtual std::size_t
  size() const = 0;

  /** \brief Pose of the sensor, sensor -> world. */
  virtual Eigen::Isometry3d
  sensorPose() const = 0;

  /** \brief Time of a cloud; none if nothing tells those of all clouds. */
  virtual std::optional<std::chrono::nanoseconds>
  stampAt(std::size_t /* index */) const
  {
    return std::nullopt;
  }

  /** \brief VIEWPOINT of the cloud's PCD file, as it is there: x y z qw qx qy qz; empty
   * if it has none. */
  virtual std::string
  viewpointAt(std::size_t /* index */) const
  {
    return {};
  }

  /** \brief Reads one cloud, in the sensor's frame.
   * \throws std::runtime_error with the file's name if it cannot be read; FieldRefusal
   * if that is for what the user wants of a field
   */
  virtual void
  read(std::size_t index, pcl::PCLPointCloud2& cloud) = 0;

private:
  std::string name_;
};

/** \brief A file or folder that a user names. */
struct SequenceInput {
  std::string path; ///< where it is read
  std::string name; ///< the path that the user gave, which names the sequence
};

/** \brief What files that are named singly become. */
enum class FileGrouping {
  OneSequence, ///< one for all of them
  ByFolder     ///< one for those of each folder
};

/** \brief Sequences of the files and folders that a user names: one for each folder, and
 * those of the files named singly; see readCloud() for the kinds of files.
 * \param[in] inputs files and folders
 * \param[in] max_frames of each sequence; 0: all
 * \param[in] bin_fields see readCloud()
 * \param[in] long_integers what becomes of them in each sequence
 * \throws std::runtime_error if a path does not exist, or a folder has no file of a cloud
 */
std::vector<std::unique_ptr<CloudSequence>>
openSequences(const std::vector<SequenceInput>& inputs,
              std::size_t max_frames,
              FileGrouping grouping,
              const std::vector<FileField>& bin_fields = {},
              const LongIntegers& long_integers = {});

/** \brief The same, with one sequence for all files named singly; remarks are printed. */
std::vector<std::unique_ptr<CloudSequence>>
openSequences(const std::vector<std::string>& inputs, std::size_t max_frames);

/** \brief Whether a file is one without a header, or a folder has such files, which
 * readCloud() reads with the fields that the user names. */
bool
hasBinFile(const std::string& path);

/** \brief Names of what is left out of a folder, as "1 folder (a) and 2 other files
 * (b, ...)"; empty if there is nothing. */
std::string
describeLeftOut(std::vector<std::string> folders, std::vector<std::string> files);

/** \brief What openSequences() leaves out of a folder: other files, and folders. Hidden
 * ones are not meant. Empty if there is nothing. */
std::string
describeIgnored(const std::string& folder);

/** \brief The stream of one sensor of the simulated robot cell.
 * \param[in] sensor 1..6
 * \param[in] frames number of frames
 * \param[in] seed of the random errors
 * \throws std::out_of_range if there is no such sensor
 */
std::unique_ptr<CloudSequence>
openCell(unsigned int sensor, std::size_t frames, std::uint32_t seed);

/** \brief The stream of the robot cell's lidar, 10 revolutions a second.
 * \param[in] revolutions their number
 * \param[in] seed of the random errors
 */
std::unique_ptr<CloudSequence>
openCellLidar(std::size_t revolutions, std::uint32_t seed);

} // namespace clouds
} // namespace pcl_ext

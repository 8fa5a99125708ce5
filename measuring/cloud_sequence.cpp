#include "measuring/cloud_sequence.h"

#include "measuring/cloud_file_headers.h"
#include "measuring/cloud_files.h"
#include "measuring/natural_order.h"

#include <pcl/conversions.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

namespace fs = std::filesystem;

std::string
describe(const PcdHeader& header)
{
  return header.width + " x " + header.height + " points with " + header.fields;
}

/** \brief Checks that the files of a stream can be those of one sensor, as far as their
 * headers tell.
 * \throws std::runtime_error with two files that cannot be
 */
void
checkSameSensor(const std::string& stream, const std::vector<std::string>& files)
{
  std::string first_file;
  std::optional<PcdHeader> first;
  bool has_moved = false;
  for (const std::string& file : files) {
    const std::optional<PcdHeader> header = readPcdHeader(file);
    if (!header)
      continue; // It is reported when it is read.
    if (!first) {
      first_file = file;
      first = header;
      continue;
    }
    // Images have a fixed size; one row has as many points as were seen.
    const bool is_image = header->height != "1" || first->height != "1";
    if (header->fields != first->fields ||
        (is_image &&
         (header->width != first->width || header->height != first->height)))
      throw std::runtime_error("'" + file + "' (" + describe(*header) +
                               ") is not of the sensor of '" + first_file + "' (" +
                               describe(*first) +
                               "): put the files of each sensor into a folder of their "
                               "own and name the folders");
    has_moved |= header->viewpoint != first->viewpoint;
  }
  if (has_moved)
    std::cerr
        << stream
        << ": the files have different viewpoints; if they are of several sensors, "
           "put those of each into a folder of their own and name the folders\n";
}

class FileSequence : public CloudSequence {
public:
  FileSequence(std::string name, std::vector<std::string> files)
  : CloudSequence(std::move(name)), files_(std::move(files))
  {}

  std::size_t
  size() const override
  {
    return files_.size();
  }

  Eigen::Isometry3d
  sensorPose() const override
  {
    return Eigen::Isometry3d::Identity();
  }

  void
  read(std::size_t index, pcl::PCLPointCloud2& cloud) override
  {
    try {
      readCloud(files_[index], cloud);
    }
    catch (const std::exception& error) {
      throw std::runtime_error("cannot read '" + files_[index] + "': " + error.what());
    }
  }

private:
  std::vector<std::string> files_;
};

class CellSequence : public CloudSequence {
public:
  CellSequence(unsigned int sensor,
               std::size_t frames,
               std::uint32_t seed,
               const cell::SensorMotion& motion)
  : CloudSequence("cell_sensor_" + std::to_string(sensor))
  , sensor_(sensor)
  , frames_(frames)
  , cell_(seed)
  {
    cell_.sensorPose(sensor); // throws if there is no such sensor
    cell_.moveSensor(sensor, motion);
  }

  std::size_t
  size() const override
  {
    return frames_;
  }

  Eigen::Isometry3d
  sensorPose() const override
  {
    return cell_.sensorPose(sensor_);
  }

  Eigen::Isometry3d
  sensorPoseAt(std::size_t index) const override
  {
    return cell_.sensorPose(sensor_, static_cast<std::uint32_t>(index));
  }

  void
  read(std::size_t index, pcl::PCLPointCloud2& cloud) override
  {
    cell_.capture(sensor_, static_cast<std::uint32_t>(index), frame_);
    pcl::toPCLPointCloud2(frame_.cloud, cloud);
  }

private:
  unsigned int sensor_;
  std::size_t frames_;
  cell::RobotCell cell_;
  cell::CellFrame frame_;
};

class LidarSequence : public CloudSequence {
public:
  LidarSequence(std::size_t revolutions,
                std::uint32_t seed,
                const cell::SensorMotion& motion)
  : CloudSequence("cell_sensor_" + std::to_string(cell::RobotCell::lidar))
  , revolutions_(revolutions)
  , cell_(seed)
  {
    cell_.moveSensor(cell::RobotCell::lidar, motion);
  }

  std::size_t
  size() const override
  {
    return revolutions_;
  }

  Eigen::Isometry3d
  sensorPose() const override
  {
    return cell_.lidarPose();
  }

  Eigen::Isometry3d
  sensorPoseAt(std::size_t index) const override
  {
    return cell_.lidarPose(static_cast<std::uint32_t>(index));
  }

  void
  read(std::size_t index, pcl::PCLPointCloud2& cloud) override
  {
    cell_.captureLidar(static_cast<std::uint32_t>(index), frame_);
    pcl::toPCLPointCloud2(frame_.cloud, cloud);
  }

private:
  std::size_t revolutions_;
  cell::RobotCell cell_;
  cell::LidarFrame frame_;
};

bool
isCloudFile(const fs::directory_entry& entry)
{
  return hasNameOfCloud(entry.path().string()) && !entry.is_directory();
}

/** \brief A folder in a folder that has files of clouds. */
std::optional<std::string>
folderOfCloudsIn(const fs::path& folder)
{
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && std::any_of(fs::directory_iterator(entry),
                                            fs::directory_iterator(),
                                            isCloudFile))
      return entry.path().string();
  return std::nullopt;
}

std::vector<std::string>
cloudFilesOf(const fs::path& folder)
{
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (isCloudFile(entry))
      files.push_back(entry.path().string());
  if (files.empty()) {
    const std::optional<std::string> inner = folderOfCloudsIn(folder);
    throw std::runtime_error("no PCD, PLY or KITTI .bin file in the folder '" +
                             folder.string() + "'" +
                             (inner ? "; name the folders in it, each of which is a "
                                      "stream, such as '" +
                                          *inner + "'"
                                    : ""));
  }
  std::sort(files.begin(), files.end(), comesBefore);
  return files;
}

std::unique_ptr<CloudSequence>
makeSequence(const std::string& name,
             std::vector<std::string> files,
             std::size_t max_frames)
{
  if (max_frames != 0 && files.size() > max_frames)
    files.resize(max_frames);
  checkSameSensor(name, files);
  return std::make_unique<FileSequence>(name, std::move(files));
}

/** \brief Numbers the sequences of the same name, as names become folders. */
void
makeNamesDistinct(std::vector<std::unique_ptr<CloudSequence>>& sequences)
{
  std::map<std::string, int> uses;
  for (const auto& sequence : sequences) {
    const int use = ++uses[sequence->name()];
    if (use > 1)
      sequence->rename(sequence->name() + "_" + std::to_string(use));
  }
}

} // namespace

std::vector<std::unique_ptr<CloudSequence>>
openSequences(const std::vector<std::string>& inputs, std::size_t max_frames)
{
  std::vector<std::unique_ptr<CloudSequence>> sequences;
  std::vector<std::string> single_files;
  for (const std::string& input : inputs) {
    // Without a trailing slash the last part of a folder's path is its name.
    const fs::path path = fs::path(input).has_filename()
                              ? fs::path(input)
                              : fs::path(input).parent_path();
    if (!fs::exists(path))
      throw std::runtime_error("there is no '" + input + "'");
    if (fs::is_directory(path))
      sequences.push_back(
          makeSequence(path.filename().string(), cloudFilesOf(path), max_frames));
    else
      single_files.push_back(input);
  }
  if (!single_files.empty()) {
    const std::string name = fs::path(single_files.front()).stem().string();
    sequences.push_back(makeSequence(name, std::move(single_files), max_frames));
  }
  makeNamesDistinct(sequences);
  return sequences;
}

std::unique_ptr<CloudSequence>
openCell(unsigned int sensor,
         std::size_t frames,
         std::uint32_t seed,
         const cell::SensorMotion& motion)
{
  return std::make_unique<CellSequence>(sensor, frames, seed, motion);
}

std::unique_ptr<CloudSequence>
openCellLidar(std::size_t revolutions,
              std::uint32_t seed,
              const cell::SensorMotion& motion)
{
  return std::make_unique<LidarSequence>(revolutions, seed, motion);
}

} // namespace measuring
} // namespace pcl_ext

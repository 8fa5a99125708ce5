#include "measuring/cloud_sequence.h"

#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace {

namespace fs = std::filesystem;

/** \brief True if a file has the lines that a PCD header must have. PCL 1.13's reader
 * does not check that and crashes on other files. */
bool
hasPcdHeader(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  bool has_fields = false;
  std::string line;
  constexpr int most_header_lines = 100;
  for (int i = 0; i < most_header_lines && std::getline(file, line); ++i) {
    has_fields |= line.rfind("FIELDS ", 0) == 0 || line.rfind("COLUMNS ", 0) == 0;
    if (line.rfind("DATA ", 0) == 0)
      return has_fields;
  }
  return false;
}

class PcdSequence : public CloudSequence {
public:
  PcdSequence(std::string name, std::vector<std::string> files)
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
    // PCL prints the reason.
    if (!hasPcdHeader(files_[index]) || reader_.read(files_[index], cloud) < 0)
      throw std::runtime_error("cannot read '" + files_[index] + "' as a PCD file");
  }

private:
  std::vector<std::string> files_;
  pcl::PCDReader reader_;
};

class CellSequence : public CloudSequence {
public:
  CellSequence(unsigned int sensor, std::size_t frames, std::uint32_t seed)
  : CloudSequence("cell_sensor_" + std::to_string(sensor))
  , sensor_(sensor)
  , frames_(frames)
  , cell_(seed)
  {
    cell_.sensorPose(sensor); // throws if there is no such sensor
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
  LidarSequence(std::size_t revolutions, std::uint32_t seed)
  : CloudSequence("cell_sensor_" + std::to_string(cell::RobotCell::lidar))
  , revolutions_(revolutions)
  , cell_(seed)
  {}

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

std::vector<std::string>
pcdFilesOf(const fs::path& folder)
{
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".pcd")
      files.push_back(entry.path().string());
  if (files.empty())
    throw std::runtime_error("no PCD file in the folder '" + folder.string() + "'");
  std::sort(files.begin(), files.end());
  return files;
}

std::unique_ptr<CloudSequence>
makeSequence(const std::string& name,
             std::vector<std::string> files,
             std::size_t max_frames)
{
  if (max_frames != 0 && files.size() > max_frames)
    files.resize(max_frames);
  return std::make_unique<PcdSequence>(name, std::move(files));
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
          makeSequence(path.filename().string(), pcdFilesOf(path), max_frames));
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
openCell(unsigned int sensor, std::size_t frames, std::uint32_t seed)
{
  return std::make_unique<CellSequence>(sensor, frames, seed);
}

std::unique_ptr<CloudSequence>
openCellLidar(std::size_t revolutions, std::uint32_t seed)
{
  return std::make_unique<LidarSequence>(revolutions, seed);
}

} // namespace measuring
} // namespace pcl_ext

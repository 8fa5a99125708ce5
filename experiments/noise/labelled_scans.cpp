#include "labelled_scans.h"

#include "clouds/cloud_files.h"

#include <pcl/common/io.h>
#include <pcl/conversions.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>

namespace pcl_ext {
namespace noise {

namespace {

bool
isMissing(const pcl::PointXYZI& point)
{
  if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z))
    return true;
  const auto all = [&](float value) {
    return point.x == value && point.y == value && point.z == value;
  };
  return all(0.0f) || (all(-1.0f) && point.intensity == -1.0f);
}

bool
has(const std::vector<std::uint16_t>& labels, std::uint16_t label)
{
  return std::find(labels.begin(), labels.end(), label) != labels.end();
}

/** \brief Points of any cloud with x, y, z; their intensity is 0 without such a field. */
void
convert(const pcl::PCLPointCloud2& from, pcl::PointCloud<pcl::PointXYZI>& cloud)
{
  const auto hasField = [&](const char* name) {
    return std::any_of(from.fields.begin(), from.fields.end(), [&](const auto& field) {
      return field.name == name;
    });
  };
  for (const char* axis : {"x", "y", "z"})
    if (!hasField(axis))
      throw std::runtime_error(std::string("it has no field '") + axis + "'");
  if (hasField("intensity")) {
    pcl::fromPCLPointCloud2(from, cloud);
    return;
  }
  pcl::PointCloud<pcl::PointXYZ> points;
  pcl::fromPCLPointCloud2(from, points);
  pcl::copyPointCloud(points, cloud);
}

/** \brief Makes an image of a cloud that is a row. */
void
setRows(std::uint32_t rows,
        const std::string& file,
        pcl::PointCloud<pcl::PointXYZI>& cloud)
{
  if (rows == 0 || cloud.size() % rows != 0)
    throw std::runtime_error("'" + file + "' has " + std::to_string(cloud.size()) +
                             " points, which are no " + std::to_string(rows) +
                             " rows of one length");
  cloud.width = static_cast<std::uint32_t>(cloud.size() / rows);
  cloud.height = rows;
}

} // namespace

void
LabelledScan::collectReturns()
{
  returns->clear();
  index_of_return.clear();
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (classes[i] != PointClass::Missing) {
      returns->push_back(cloud[i]);
      index_of_return.push_back(i);
    }
}

PointClass
LabelMeanings::classOf(std::uint16_t label) const
{
  if (has(ignored, label))
    return PointClass::Ignored;
  if (has(noise, label))
    return PointClass::Noise;
  if (has(persons, label))
    return PointClass::Person;
  return has(poles, label) ? PointClass::Pole : PointClass::Surface;
}

ScansOfFolder::ScansOfFolder(const std::string& folder,
                             LabelMeanings meanings,
                             std::uint32_t rows)
: files_(clouds::findLabelledFiles(folder)), meanings_(std::move(meanings)), rows_(rows)
{}

void
ScansOfFolder::read(std::size_t index, LabelledScan& scan)
{
  const clouds::LabelledFile& file = files_.at(index);
  std::vector<std::uint16_t> labels;
  try {
    pcl::PCLPointCloud2 content;
    clouds::readCloud(file.cloud, content);
    convert(content, scan.cloud);
    if (file.labels.empty())
      labels = clouds::labelsOf(content);
  }
  catch (const std::exception& error) {
    throw std::runtime_error("'" + file.cloud + "': " + error.what());
  }
  if (!file.labels.empty())
    labels = clouds::readLabels(file.labels, scan.cloud.size());
  scan.name = std::filesystem::path(file.cloud).stem().string();
  scan.cloud.is_dense = false;
  if (scan.cloud.height == 1)
    setRows(rows_, file.cloud, scan.cloud);
  scan.classes.resize(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    pcl::PointXYZI& point = scan.cloud[i];
    const bool missing = isMissing(point);
    scan.classes[i] = missing ? PointClass::Missing : meanings_.classOf(labels[i]);
    if (missing)
      point.getVector3fMap().setConstant(std::numeric_limits<float>::quiet_NaN());
  }
  scan.collectReturns();
}

void
ScansOfCell::read(std::size_t index, LabelledScan& scan)
{
  const auto revolution = static_cast<std::uint32_t>(index);
  cell_.captureLidar(revolution, captured_);
  scan.name = std::to_string(index);
  scan.cloud = captured_.cloud;
  const std::vector<cell::Material>& materials =
      cell_.lidarSurfaces(revolution).material;
  scan.classes.assign(scan.cloud.size(), PointClass::Noise);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i)
    if (captured_.truth[i] == cell::PointTruth::None)
      scan.classes[i] = PointClass::Missing;
    else if (captured_.truth[i] == cell::PointTruth::Surface)
      // Only the person wears cloth.
      scan.classes[i] = materials[i] == cell::Material::Cloth ? PointClass::Person
                                                              : PointClass::Surface;
  scan.collectReturns();
}

} // namespace noise
} // namespace pcl_ext

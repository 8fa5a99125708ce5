#include "clouds/label_files.h"

#include "clouds/natural_order.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace clouds {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t label_bytes = 4;

std::vector<std::string>
filesOf(const fs::path& folder, const std::string& extension)
{
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() == extension)
      files.push_back(entry.path().string());
  std::sort(files.begin(), files.end(), comesBefore);
  return files;
}

/** \brief The .bin files of a folder with their labels. */
std::vector<LabelledFile>
findPairs(const fs::path& scans, const fs::path& labels)
{
  std::vector<LabelledFile> pairs;
  for (const std::string& cloud : filesOf(scans, ".bin")) {
    const fs::path label = labels / fs::path(cloud).stem().concat(".label");
    if (!fs::is_regular_file(label))
      throw std::runtime_error("'" + cloud + "' has no labels: there is no '" +
                               label.string() + "'");
    pairs.push_back({cloud, label.string()});
  }
  return pairs;
}

/** \brief Class of a field's value of some integer type. */
template <typename IntegerT>
std::uint16_t
classAt(const std::uint8_t* at)
{
  IntegerT value{};
  std::memcpy(&value, at, sizeof(value));
  return static_cast<std::uint16_t>(value);
}

using ClassReader = std::uint16_t (*)(const std::uint8_t*);

/** \brief Null for types that are no integers. */
ClassReader
classReaderOf(std::uint8_t type)
{
  using Field = pcl::PCLPointField;
  switch (type) {
  case Field::INT8:
    return classAt<std::int8_t>;
  case Field::UINT8:
    return classAt<std::uint8_t>;
  case Field::INT16:
    return classAt<std::int16_t>;
  case Field::UINT16:
    return classAt<std::uint16_t>;
  case Field::INT32:
    return classAt<std::int32_t>;
  case Field::UINT32:
    return classAt<std::uint32_t>;
  default:
    return nullptr;
  }
}

} // namespace

std::vector<LabelledFile>
findLabelledFiles(const std::string& folder)
{
  if (!fs::is_directory(folder))
    throw std::runtime_error("'" + folder + "' is no folder");
  const fs::path path(folder);
  const std::pair<fs::path, fs::path> layouts[] = {
      {path / "velodyne", path / "labels"},
      {path / "snow_velodyne", path / "snow_labels"},
      {path, path}};
  for (const auto& [scans, labels] : layouts)
    if (fs::is_directory(scans))
      if (std::vector<LabelledFile> pairs = findPairs(scans, labels); !pairs.empty())
        return pairs;
  std::vector<LabelledFile> files;
  for (const std::string& cloud : filesOf(path, ".pcd"))
    files.push_back({cloud, {}});
  if (files.empty())
    throw std::runtime_error(
        "'" + folder +
        "' has no labelled scans: neither .bin files with .label files, in it or in "
        "'velodyne' and 'labels' or 'snow_velodyne' and 'snow_labels', nor PCD files");
  return files;
}

std::vector<std::uint16_t>
readLabels(const std::string& path, std::size_t points)
{
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw std::runtime_error("cannot open '" + path + "'");
  const std::uint64_t bytes = fs::file_size(path);
  if (bytes != label_bytes * points)
    throw std::runtime_error("'" + path + "' has " + std::to_string(bytes) +
                             " bytes, but its cloud has " + std::to_string(points) +
                             " points with labels of 4 bytes, which are " +
                             std::to_string(label_bytes * points) + " bytes");
  std::vector<std::uint8_t> content(bytes);
  file.read(reinterpret_cast<char*>(content.data()),
            static_cast<std::streamsize>(content.size()));
  if (!file)
    throw std::runtime_error("reading '" + path + "' failed");
  std::vector<std::uint16_t> classes(points);
  for (std::size_t i = 0; i < points; ++i)
    classes[i] = static_cast<std::uint16_t>(content[label_bytes * i] |
                                            content[label_bytes * i + 1] << 8);
  return classes;
}

std::vector<std::uint16_t>
labelsOf(const pcl::PCLPointCloud2& cloud)
{
  const auto field = std::find_if(
      cloud.fields.begin(), cloud.fields.end(), [](const pcl::PCLPointField& other) {
        return other.name == "label";
      });
  if (field == cloud.fields.end())
    throw std::runtime_error("it has no field 'label'");
  const ClassReader classOf = classReaderOf(field->datatype);
  if (classOf == nullptr)
    throw std::runtime_error("its field 'label' has no integers");
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  std::vector<std::uint16_t> classes(points);
  for (std::size_t i = 0; i < points; ++i)
    classes[i] = classOf(&cloud.data.at(i * cloud.point_step + field->offset));
  return classes;
}

} // namespace clouds
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_files.h"

#include "clouds/bin_file.h"
#include "clouds/file_text.h"
#include "clouds/pcd_file.h"
#include "clouds/ply_file.h"
#include "clouds/usual_fields.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace clouds {

namespace {

namespace fs = std::filesystem;

std::string
extensionOf(const std::string& path)
{
  std::string extension = fs::path(path).extension().string();
  std::transform(
      extension.begin(), extension.end(), extension.begin(), [](unsigned char letter) {
        return static_cast<char>(std::tolower(letter));
      });
  return extension;
}

/** \brief Whether a point has coordinates that no sensor measures: a huge one, or
 * nothing but tiny ones; none: it has none that are finite and not 0, as those of
 * missing points. */
std::optional<bool>
isOdd(const std::uint8_t* point,
      const std::vector<std::uint32_t>& offsets,
      bool is_double)
{
  const double largest = is_double ? 1e15 : 1e9;
  constexpr double smallest = 1e-20;
  bool is_huge = false;
  bool is_tiny = true;
  bool is_there = false;
  for (const std::uint32_t offset : offsets) {
    double coordinate = 0.0;
    float less_precise = 0.0f;
    if (is_double)
      std::memcpy(&coordinate, point + offset, sizeof(coordinate));
    else
      std::memcpy(&less_precise, point + offset, sizeof(less_precise));
    const double length = std::abs(is_double ? coordinate : double{less_precise});
    if (!std::isfinite(length) || length == 0.0)
      continue;
    is_there = true;
    is_huge |= length > largest;
    is_tiny &= length < smallest;
  }
  return is_there ? std::optional<bool>(is_huge || is_tiny) : std::nullopt;
}

/** \brief Refuses coordinates that no sensor measures, as those of bytes in the wrong
 * order are. */
void
checkCoordinates(const pcl::PCLPointCloud2& cloud)
{
  std::vector<std::uint32_t> offsets;
  std::size_t doubles = 0;
  for (const pcl::PCLPointField& field : cloud.fields)
    if ((field.name == "x" || field.name == "y" || field.name == "z") &&
        (field.datatype == pcl::PCLPointField::FLOAT32 ||
         field.datatype == pcl::PCLPointField::FLOAT64)) {
      offsets.push_back(field.offset);
      doubles += field.datatype == pcl::PCLPointField::FLOAT64 ? 1 : 0;
    }
  const bool is_double = doubles > 0;
  if (offsets.empty() || (is_double && doubles != offsets.size()))
    return; // Who reads the coordinates refuses them.
  constexpr std::size_t most_checked = 4096;
  std::size_t checked = 0;
  std::size_t odd = 0;
  for (std::size_t at = 0;
       at + cloud.point_step <= cloud.data.size() && checked < most_checked;
       at += cloud.point_step)
    if (const std::optional<bool> is_odd = isOdd(&cloud.data[at], offsets, is_double)) {
      ++checked;
      odd += *is_odd ? 1 : 0;
    }
  if (odd > 0 && 2 * odd >= checked)
    fail("its coordinates are no lengths: the bytes of its numbers may be in the wrong "
         "order, or its fields are others than its header tells");
}

/** \brief The first bytes of a file. */
std::string
beginningOf(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  std::array<char, 256> first{};
  file.read(first.data(), static_cast<std::streamsize>(first.size()));
  if (!file && !file.eof())
    fail("cannot open '" + path + "': " + std::strerror(errno));
  return {first.data(), static_cast<std::size_t>(file.gcount())};
}

/** \brief Whether bytes are those of text. Those of more than a few numbers in binary
 * form are not. */
bool
isText(const std::string& bytes)
{
  return bytes.rfind(byte_order_mark, 0) == 0 ||
         std::all_of(bytes.begin(), bytes.end(), [](char byte) {
           return (byte >= ' ' && byte <= '~') || byte == '\t' || byte == '\r' ||
                  byte == '\n';
         });
}

/** \brief What a file is that other programs make a cloud or a bag of, and the next
 * command; empty if it is none of these.
 * \param[in] beginning its first bytes
 */
std::string
describeForeignFile(const std::string& beginning)
{
  const std::string compressed = "it is a compressed file: decompress it with '";
  const std::string packets =
      "it has packets of a network: record the sensor_msgs/msg/PointCloud2 that the "
      "sensor's driver makes of them with 'ros2 bag record'";
  const std::string survey = "it is a cloud of surveyors: convert it with 'pdal "
                             "translate IN OUT.ply'";
  const std::pair<std::string, std::string> beginnings[] = {
      {"version https://git-lfs",
       "it stands for a file that Git LFS keeps elsewhere: fetch that with 'git lfs "
       "pull'"},
      {"\x1f\x8b\x08", compressed + "gzip -dk'"},
      {"BZh", compressed + "bzip2 -dk'"},
      {"\xfd"
       "7zXZ",
       compressed + "xz -dk'"},
      {"\x04\x22M\x18", compressed + "lz4 -dk'"},
      {"\x28\xb5\x2f\xfd",
       "it is a compressed file of no bag, or one that was cut off: decompress it with "
       "'zstd -dk'"},
      {"PK\x03\x04", "it is an archive: unpack it with 'unzip'"},
      {"DRACO",
       "it is compressed by Draco: decode it with 'draco_decoder -i IN -o OUT.ply'"},
      {"LASF", survey},
      {"ASTM-E57", survey},
      {"\xd4\xc3\xb2\xa1", packets},
      {"\xa1\xb2\xc3\xd4", packets},
      {"\x4d\x3c\xb2\xa1", packets},
      {"\x0a\x0d\x0d\x0a", packets},
      {"\x93NUMPY",
       "it is an array of NumPy: write it with tofile() into a .bin file, whose fields "
       "--bin-fields names"},
      {"rosbag2_bagfile_information:",
       "it tells of a bag: name the folder in which it is"}};
  for (const auto& [text, description] : beginnings)
    if (beginning.rfind(text, 0) == 0)
      return description;
  return {};
}

} // namespace

bool
isEmptyFile(const std::string& path)
{
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  return !error && bytes == 0;
}

FileKind
kindOf(const std::string& path)
{
  if (isEmptyFile(path))
    return FileKind::Empty;
  const std::string beginning = beginningOf(path);
  if (beginning.empty())
    return FileKind::Empty;
  const std::pair<const char*, FileKind> beginnings[] = {
      {"# .PCD", FileKind::Pcd},
      {"VERSION ", FileKind::Pcd},
      {"FIELDS ", FileKind::Pcd},
      {"ply\n", FileKind::Ply},
      {"ply\r", FileKind::Ply},
      {"ply ", FileKind::Ply},
      {"ply\t", FileKind::Ply},
      {"\x89MCAP", FileKind::Mcap},
      {"#ROSBAG", FileKind::Ros1Bag},
      {"SQLite format 3", FileKind::Sqlite},
      {"PCXI", FileKind::Recording},
      {"<HEAD>", FileKind::Recording},
      {"<PCL-OCT-COMPRESSED>", FileKind::PclCompressed},
      {"<PCL-ORG-COMPRESSED>", FileKind::PclCompressed}};
  for (const auto& [text, kind] : beginnings)
    if (beginning.rfind(text, 0) == 0)
      return kind;
  if (!describeForeignFile(beginning).empty())
    return FileKind::Foreign;
  const std::string extension = extensionOf(path);
  if (extension == ".pcd") // a comment may be first
    return FileKind::Pcd;
  if (isText(beginning))
    return FileKind::Text;
  return extension == ".bin" ? FileKind::Bin : FileKind::Unknown;
}

std::string
whyNotACloud(FileKind kind, const std::string& path)
{
  switch (kind) {
  case FileKind::Empty:
    return "it is empty";
  case FileKind::Mcap:
  case FileKind::Sqlite:
    return "it is a bag, which cannot be encoded together with files: name it alone";
  case FileKind::Ros1Bag:
    return "it is a bag of ROS 1, which cannot be encoded together with files: name it "
           "alone";
  case FileKind::Recording:
    return "it is a recording that is encoded already: see it with 'pcl_ext info'";
  case FileKind::PclCompressed:
    return "it is a stream of PCL's own class: decode it with "
           "pcl::io::OctreePointCloudCompression";
  case FileKind::Foreign:
    return describeForeignFile(beginningOf(path));
  default:
    break;
  }
  const std::string extension = extensionOf(path);
  if (extension == ".obj" || extension == ".stl" || extension == ".vtk")
    return "it is a mesh: convert it with 'pcl_converter IN OUT.ply'";
  if (kind == FileKind::Text)
    return "it is text that does not begin as PCD and PLY files do; before numbers of "
           "x, y, z the lines 'FIELDS x y z', 'SIZE 4 4 4', 'TYPE F F F', 'WIDTH' with "
           "the number of points, and 'DATA ascii' make a PCD file of it";
  return "it is no PCD or PLY file, no MCAP file and no bag, and its name does not "
         "end in .bin as files of KITTI's or nuScenes' lidar; --bin-fields names the "
         "fields of other files of binary numbers without a header";
}

bool
hasNameOfCloud(const std::string& path)
{
  const std::string extension = extensionOf(path);
  return extension == ".pcd" || extension == ".ply" || extension == ".bin";
}

std::vector<std::string>
readCloud(const std::string& path,
          pcl::PCLPointCloud2& cloud,
          const std::vector<FileField>& bin_fields,
          UsualFields* of_stream)
{
  const FileKind kind = kindOf(path);
  std::vector<std::string> remarks;
  if (kind == FileKind::Pcd)
    remarks = readPcd(path, cloud);
  else if (kind == FileKind::Ply)
    remarks = readPly(path, cloud);
  else if (kind == FileKind::Bin || (kind == FileKind::Unknown && !bin_fields.empty()))
    remarks = readBin(path, bin_fields, cloud);
  else
    fail(whyNotACloud(kind, path));
  cloud.header = pcl::PCLHeader();
  UsualFields of_file;
  const std::vector<std::string> of_fields =
      (of_stream != nullptr ? *of_stream : of_file)
          .giveTo(cloud, kind == FileKind::Ply);
  remarks.insert(remarks.end(), of_fields.begin(), of_fields.end());
  checkCoordinates(cloud);
  return remarks;
}

} // namespace clouds
} // namespace pcl_ext

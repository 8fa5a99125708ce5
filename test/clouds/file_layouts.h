// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "clouds/bin_file.h"
#include "clouds/cloud_files.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext::clouds::test {

using Remarks = std::vector<std::string>;

inline void
expectPart(const std::string& message, const std::string& part)
{
  EXPECT_TRUE(pcl_ext::test::hasPart(message, part));
}

/** \brief A PCD file.
 * \param[in] fields their names, each followed by its type, size and count if these are
 * not F, 4 and 1: "x y z ring:U2 pair:F4x2"
 */
inline std::string
pcd(const std::string& fields, std::size_t points, const std::string& data)
{
  std::string names;
  std::string sizes;
  std::string types;
  std::string counts;
  std::istringstream words(fields);
  for (std::string word; words >> word;) {
    const std::size_t colon = word.find(':');
    const std::string type = colon < word.size() ? word.substr(colon + 1) : "F4";
    const std::size_t times = type.find('x');
    names += ' ' + word.substr(0, colon);
    sizes += ' ' + type.substr(1, times - 1);
    types += ' ' + type.substr(0, 1);
    counts += ' ' + (times < type.size() ? type.substr(times + 1) : "1");
  }
  return "VERSION .7\nFIELDS" + names + "\nSIZE" + sizes + "\nTYPE" + types +
         "\nCOUNT" + counts + "\nWIDTH " + std::to_string(points) +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) +
         "\nDATA " + data;
}

inline std::string
ply(const std::string& format, const std::string& properties, const std::string& points)
{
  return "ply\nformat " + format + " 1.0\nelement vertex 2\n" + properties +
         "end_header\n" + points;
}

/** \brief Files that other programs write in other ways than PCL. */
class FileLayouts : public ::testing::Test {
protected:
  Remarks
  read(const std::string& name,
       const std::string& bytes,
       const std::string& bin_fields = "")
  {
    cloud_ = {}; // so that nothing of the last file is seen
    recording::test::writeText(folder_ / name, bytes);
    return readCloud(folder_ / name,
                     cloud_,
                     bin_fields.empty() ? std::vector<FileField>()
                                        : parseBinFields(bin_fields));
  }

  Remarks
  readPcd(const std::string& fields, std::size_t points, const std::string& data)
  {
    return read("a.pcd", pcd(fields, points, data));
  }

  Remarks
  readPly(const std::string& format,
          const std::string& properties,
          const std::string& points)
  {
    return read("a.ply", ply(format, properties, points));
  }

  std::string
  refusal(const std::string& name,
          const std::string& bytes,
          const std::string& bin_fields = "")
  {
    try {
      read(name, bytes, bin_fields);
    }
    catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  /** \brief Numbers of a field, which must have this datatype. */
  template <typename NumberT>
  std::vector<NumberT>
  numbers(const std::string& name, std::uint8_t datatype) const
  {
    std::vector<NumberT> found;
    for (const pcl::PCLPointField& field : cloud_.fields)
      if (field.name == name) {
        EXPECT_EQ(field.datatype, datatype) << name;
        for (std::size_t i = 0; i < std::size_t{cloud_.width} * cloud_.height; ++i) {
          NumberT number;
          std::memcpy(&number,
                      &cloud_.data[i * cloud_.point_step + field.offset],
                      sizeof(number));
          found.push_back(number);
        }
      }
    return found;
  }

  std::vector<float>
  floats(const std::string& name) const
  {
    return numbers<float>(name, pcl::PCLPointField::FLOAT32);
  }

  std::vector<double>
  doubles(const std::string& name) const
  {
    return numbers<double>(name, pcl::PCLPointField::FLOAT64);
  }

  /** \brief The low 24 bits of a packed colour. */
  std::vector<std::uint32_t>
  colours(const std::string& name, std::uint8_t datatype) const
  {
    std::vector<std::uint32_t> bits = numbers<std::uint32_t>(name, datatype);
    for (std::uint32_t& colour : bits)
      colour &= 0xffffff;
    return bits;
  }

  std::string
  fieldNames() const
  {
    std::string names;
    for (const pcl::PCLPointField& field : cloud_.fields)
      names += (names.empty() ? "" : " ") + field.name;
    return names;
  }

  recording::test::TestFolder folder_;
  pcl::PCLPointCloud2 cloud_;
};

template <typename NumberT>
void
append(NumberT number, std::string& bytes)
{
  std::array<char, sizeof(number)> of_number{};
  std::memcpy(of_number.data(), &number, sizeof(number));
  bytes.append(of_number.data(), of_number.size());
}

inline const std::string xyz = "property float x\nproperty float y\nproperty float z\n";

using F = pcl::PCLPointField;
using Floats = std::vector<float>;
using Doubles = std::vector<double>;
using Colours = std::vector<std::uint32_t>;

} // namespace pcl_ext::clouds::test

/*
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *  Point Cloud Library (PCL) - www.pointclouds.org
 *  Copyright (c) 2014-, Open Perception Inc.
 *
 *  All rights reserved
 */

#pragma once

#include <pcl/common/io.h> // for getFields
#include <pcl/common/point_tests.h>
#include <pcl/compression/entropy_range_coder.h>
#include <pcl/console/print.h>
#include <pcl/PCLPointField.h>
#include <pcl/point_cloud.h>
#include <pcl/type_traits.h> // for asEnum_v

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace pcl {
namespace octree {

/** \brief @b ScalarFieldCoding class
 *
 * Codes scalar fields of points, such as their intensity, for octree-based point cloud
 * compression. As with ColorCoding, a voxel has the average of its points; where the
 * points of a voxel are coded one by one, and it has several, each of them has its
 * difference to that average, too.
 *
 * Values become levels: whole numbers of steps above the lowest value of the frame.
 * Where all values of a field are whole numbers and their range is at most
 * 2^bit_depth - 1, the step is 1: values are exact, averages are rounded to whole
 * numbers. Otherwise the step is the range divided by 2^bit_depth - 1, and the error of
 * a value or average is at most half of it. Values that are NaN or infinite become NaN
 * and do not count in averages. If there are any, there is one step less.
 *
 * The coded fields precede the header of their frame, behind an identifier of their
 * own. A decoder that does not know them passes over them while it looks for the
 * header.
 *
 * A field is coded if it is one number: an integer of 8, 16 or 32 bits, float or
 * double. Coordinates and colors are not.
 * \tparam PointT type of the points
 * \ingroup io
 */
template <typename PointT>
class ScalarFieldCoding {
public:
  using PointCloud = pcl::PointCloud<PointT>;

  /** \brief Text that precedes the coded fields of a frame. */
  static constexpr const char* identifier = "<PCL-OCT-SCALAR-FIELDS>";

  /** \brief Select the field intensity, if PointT has it, with 16 bits. */
  ScalarFieldCoding()
  {
    CodedField coded;
    if (findField("intensity", coded.field))
      encoded_.push_back(coded);
  }

  /** \brief Select the fields to encode.
   * \param[in] names names of fields; those that PointT does not have, or that cannot
   * be coded, are left out with a warning
   * \param[in] bit_depth most bits of a value; less than 2 are changed to 2 and more
   * than 16 to 16, with a warning
   */
  void
  setFields(const std::vector<std::string>& names, unsigned char bit_depth)
  {
    bit_depth_ = std::clamp<unsigned char>(bit_depth, 2, 16);
    if (bit_depth_ != bit_depth)
      PCL_WARN("[pcl::octree::ScalarFieldCoding::setFields] bit_depth has to be from 2 "
               "to 16, but is %d! Using %d.\n",
               static_cast<int>(bit_depth),
               static_cast<int>(bit_depth_));
    encoded_.clear();
    for (const std::string& name : names) {
      CodedField coded;
      if (!findField(name, coded.field))
        PCL_WARN("[pcl::octree::ScalarFieldCoding::setFields] The point type has no "
                 "field '%s' that can be coded! Leaving it out.\n",
                 name.c_str());
      else if (!contains(encoded_, name))
        encoded_.push_back(coded);
    }
  }

  /** \brief Prepare for a frame: find the range of each field.
   * \param[in] cloud the cloud that is to be encoded
   */
  void
  initializeEncoding(const PointCloud& cloud)
  {
    for (CodedField& coded : encoded_) {
      coded.averages.clear();
      coded.differences.clear();
      findScale(cloud, coded);
    }
  }

  /** \brief Encode the average of the points of a voxel.
   * \param[in] indices the points of the voxel
   * \param[in] cloud the cloud that is encoded
   */
  void
  encodeAverageOfPoints(const Indices& indices, const PointCloud& cloud)
  {
    for (CodedField& coded : encoded_)
      coded.averages.push_back(averageLevel(indices, cloud, coded));
  }

  /** \brief Encode the average of the points of a voxel and, if there are several, each
   * point's difference to it.
   * \param[in] indices the points of the voxel
   * \param[in] cloud the cloud that is encoded
   */
  void
  encodePoints(const Indices& indices, const PointCloud& cloud)
  {
    for (CodedField& coded : encoded_) {
      const std::uint16_t average = averageLevel(indices, cloud, coded);
      coded.averages.push_back(average);
      if (indices.size() < 2)
        continue;
      for (const auto& index : indices) {
        const std::uint16_t level = toLevel(getValue(cloud[index], coded.field), coded);
        // wraps around, as does its inverse in decodePoints
        coded.differences.push_back(static_cast<std::uint16_t>(level - average));
      }
    }
  }

  /** \brief Write the fields of a frame to a stream, nothing if none is selected.
   * \param[in,out] stream binary output stream
   * \param[in] coder entropy coder
   * \return number of bytes written
   */
  std::uint64_t
  encodeToStream(std::ostream& stream, StaticRangeCoder& coder) const
  {
    if (encoded_.empty())
      return 0;

    std::ostringstream content;
    write(content, static_cast<std::uint32_t>(encoded_.size()));
    for (const CodedField& coded : encoded_) {
      write(content, static_cast<std::uint32_t>(coded.field.name.size()));
      content << coded.field.name;
      write(content, coded.lowest);
      write(content, coded.highest);
      write(content, coded.steps);
      writeLevels(content, coded.averages, coded.steps, coder);
      writeLevels(content, coded.differences, coded.steps, coder);
    }

    const std::string bytes = content.str();
    stream << identifier;
    write(stream, static_cast<std::uint32_t>(bytes.size()));
    stream << bytes;
    return std::strlen(identifier) + sizeof(std::uint32_t) + bytes.size();
  }

  /** \brief Forget the fields of the frame before. */
  void
  initializeDecoding()
  {
    block_.clear();
    decoded_.clear();
  }

  /** \brief Read the fields of a frame, without decoding them, from a stream that
   * stands behind the identifier.
   * \param[in,out] stream binary input stream; fails if it ends before the fields do
   * \return number of bytes read
   */
  std::uint64_t
  readFromStream(std::istream& stream)
  {
    block_ = readBytes(stream, read<std::uint32_t>(stream));
    if (!stream) {
      block_.clear();
      return 0;
    }
    return std::strlen(identifier) + sizeof(std::uint32_t) + block_.size();
  }

  /** \brief Decode the fields that were read. If they end too early, have more values
   * than there can be, or a frequency table that StaticRangeCoder cannot decode with,
   * no values are decoded. Other damage is not noticed and leads to wrong values.
   * \param[in] coder entropy coder
   * \param[in] max_count most points that the frame can have
   */
  void
  decodeFields(StaticRangeCoder& coder, std::uint64_t max_count)
  {
    decoded_.clear();
    if (block_.empty())
      return;
    std::istringstream content(block_);
    block_.clear();
    const auto field_count = read<std::uint32_t>(content);
    for (std::uint32_t i = 0; i < field_count; ++i) {
      CodedField coded;
      const std::string name = readBytes(content, read<std::uint32_t>(content));
      coded.lowest = read<double>(content);
      coded.highest = read<double>(content);
      coded.steps = read<std::uint32_t>(content);
      if (!readLevels(content, coded.averages, coded.steps, coder, max_count) ||
          !readLevels(content, coded.differences, coded.steps, coder, max_count)) {
        decoded_.clear();
        return;
      }
      if (findField(name, coded.field) && !contains(decoded_, name))
        decoded_.push_back(std::move(coded));
    }
  }

  /** \brief Set the fields of the points of the next voxel. Points for which the stream
   * has no value keep theirs.
   * \param[in,out] cloud the cloud that is decoded
   * \param[in] begin index of the first point of the voxel
   * \param[in] end index behind the last point of the voxel
   */
  void
  decodePoints(PointCloud& cloud, std::size_t begin, std::size_t end)
  {
    for (CodedField& coded : decoded_) {
      if (coded.next_average == coded.averages.size())
        continue;
      const std::uint16_t average = coded.averages[coded.next_average++];
      if (end - begin == 1) {
        setValue(cloud[begin], coded.field, toValue(average, coded));
        continue;
      }
      for (std::size_t i = begin; i < end; ++i) {
        if (coded.next_difference == coded.differences.size())
          break;
        const std::uint16_t difference = coded.differences[coded.next_difference++];
        const int mask = levelBytes(coded.steps) == 1 ? 0xFF : 0xFFFF;
        const auto level = static_cast<std::uint16_t>((average + difference) & mask);
        setValue(cloud[i], coded.field, toValue(level, coded));
      }
    }
  }

protected:
  /** \brief A field and its values in a frame. A level is a number of steps from the
   * lowest value; that above the highest stands for values that are not finite. */
  struct CodedField {
    pcl::PCLPointField field;
    double lowest = 0.0;
    double highest = 0.0;
    std::uint32_t steps = 0;
    std::vector<std::uint16_t> averages;
    std::vector<std::uint16_t> differences;
    std::size_t next_average = 0;
    std::size_t next_difference = 0;
  };

  /** \brief Call a function with a value of the type of a field.
   * \return false, without a call, if fields of that type are not coded
   */
  template <typename FunctionT>
  static bool
  withTypeOf(const pcl::PCLPointField& field, FunctionT function)
  {
    return withOneOf<std::int8_t,
                     std::uint8_t,
                     std::int16_t,
                     std::uint16_t,
                     std::int32_t,
                     std::uint32_t,
                     float,
                     double>(field.datatype, function);
  }

  template <typename... Ts, typename FunctionT>
  static bool
  withOneOf(std::uint8_t datatype, FunctionT function)
  {
    return ((datatype == pcl::traits::asEnum_v<Ts> && (function(Ts()), true)) || ...);
  }

  /** \brief Find a field of PointT that can be coded. */
  static bool
  findField(const std::string& name, pcl::PCLPointField& found)
  {
    for (const char* other : {"x", "y", "z", "rgb", "rgba"})
      if (name == other)
        return false;
    for (const pcl::PCLPointField& field : pcl::getFields<PointT>())
      if (field.name == name && field.count == 1 && withTypeOf(field, [](auto) {})) {
        found = field;
        return true;
      }
    return false;
  }

  static bool
  contains(const std::vector<CodedField>& fields, const std::string& name)
  {
    return std::any_of(fields.begin(), fields.end(), [&name](const CodedField& coded) {
      return coded.field.name == name;
    });
  }

  static double
  getValue(const PointT& point, const pcl::PCLPointField& field)
  {
    const char* bytes = reinterpret_cast<const char*>(&point) + field.offset;
    double value = 0.0;
    withTypeOf(field, [bytes, &value](auto typed) {
      std::memcpy(&typed, bytes, sizeof(typed));
      value = static_cast<double>(typed);
    });
    return value;
  }

  static void
  setValue(PointT& point, const pcl::PCLPointField& field, double value)
  {
    char* bytes = reinterpret_cast<char*>(&point) + field.offset;
    withTypeOf(field, [bytes, value](auto typed) mutable {
      using T = decltype(typed);
      if constexpr (std::is_integral_v<T>)
        value = std::isnan(value) ? 0.0 : std::round(value);
      // damaged streams can have any value
      typed = static_cast<T>(
          std::clamp(value,
                     static_cast<double>(std::numeric_limits<T>::lowest()),
                     static_cast<double>(std::numeric_limits<T>::max())));
      std::memcpy(bytes, &typed, sizeof(typed));
    });
  }

  /** \brief Set the scale of a field by its values in a cloud. */
  void
  findScale(const PointCloud& cloud, CodedField& coded) const
  {
    coded.lowest = std::numeric_limits<double>::max();
    coded.highest = std::numeric_limits<double>::lowest();
    bool all_finite = true;
    bool all_whole = true;
    for (const PointT& point : cloud) {
      if (!pcl::isFinite(point)) // not in the octree
        continue;
      const double value = getValue(point, coded.field);
      if (std::isfinite(value)) {
        coded.lowest = std::min(coded.lowest, value);
        coded.highest = std::max(coded.highest, value);
        all_whole = all_whole && value == std::floor(value);
      }
      else
        all_finite = false;
    }
    if (coded.lowest > coded.highest)
      coded.lowest = coded.highest = 0.0;

    // there are 2^bit_depth_ levels, of which one may be needed for what is not finite
    coded.steps = (1u << bit_depth_) - (all_finite ? 1 : 2);
    const double range = coded.highest - coded.lowest;
    if (all_whole && range <= coded.steps) {
      coded.steps = static_cast<std::uint32_t>(range);
      // With 255 steps of 1 the level of what is not finite would need a second byte,
      // which a level has from 256 steps on: steps of 1/2, which are exact, too.
      if (coded.steps == 255 && !all_finite)
        coded.steps = 510;
    }
    else if (halfRange(coded) == 0.0)
      coded.steps = 0;
  }

  /** \brief Half of the range, which is finite for the whole range of double, too. */
  static double
  halfRange(const CodedField& coded)
  {
    return 0.5 * coded.highest - 0.5 * coded.lowest;
  }

  static std::uint16_t
  toLevel(double value, const CodedField& coded)
  {
    if (!std::isfinite(value))
      return static_cast<std::uint16_t>(coded.steps + 1);
    if (coded.steps == 0)
      return 0;
    const double position = (0.5 * value - 0.5 * coded.lowest) / halfRange(coded);
    // an average may be rounded to outside of the range
    return static_cast<std::uint16_t>(
        std::lround(std::clamp(position, 0.0, 1.0) * coded.steps));
  }

  static double
  toValue(std::uint16_t level, const CodedField& coded)
  {
    if (level > coded.steps)
      return std::numeric_limits<double>::quiet_NaN();
    if (coded.steps == 0)
      return coded.lowest;
    const double range = coded.highest - coded.lowest;
    if (range <= coded.steps) // in this order whole numbers are exact
      return coded.lowest + range * level / coded.steps;
    // the range can be infinite
    const double position = static_cast<double>(level) / coded.steps;
    return (1.0 - position) * coded.lowest + position * coded.highest;
  }

  /** \brief Level of the average of those values that are finite. */
  static std::uint16_t
  averageLevel(const Indices& indices, const PointCloud& cloud, const CodedField& coded)
  {
    double sum = 0.0;
    std::size_t count = 0;
    for (const auto& index : indices) {
      const double value = getValue(cloud[index], coded.field);
      if (std::isfinite(value)) {
        sum += value;
        ++count;
      }
    }
    // without such values 0 / 0, which is not finite
    return toLevel(sum / static_cast<double>(count), coded);
  }

  template <typename T>
  static void
  write(std::ostream& stream, const T& value)
  {
    stream.write(reinterpret_cast<const char*>(&value), sizeof(value));
  }

  /** \brief Read a value, 0 if the stream has ended. */
  template <typename T>
  static T
  read(std::istream& stream)
  {
    T value = 0;
    stream.read(reinterpret_cast<char*>(&value), sizeof(value));
    return stream ? value : 0;
  }

  /** \brief Read so many bytes, less if the stream ends before. */
  static std::string
  readBytes(std::istream& stream, std::size_t size)
  {
    std::string bytes;
    std::array<char, 4096> part;
    while (stream && bytes.size() < size) {
      const std::size_t wanted = std::min(part.size(), size - bytes.size());
      stream.read(part.data(), static_cast<std::streamsize>(wanted));
      bytes.append(part.data(), static_cast<std::size_t>(stream.gcount()));
    }
    return bytes;
  }

  /** \brief Number of bytes of a level. */
  static int
  levelBytes(std::uint32_t steps)
  {
    return steps < 256 ? 1 : 2;
  }

  /** \brief Write levels: the low bytes of all, then the high bytes. */
  static void
  writeLevels(std::ostream& stream,
              const std::vector<std::uint16_t>& levels,
              std::uint32_t steps,
              StaticRangeCoder& coder)
  {
    write(stream, static_cast<std::uint64_t>(levels.size()));
    if (levels.empty())
      return;
    std::vector<char> bytes(levels.size());
    for (int byte = 0; byte < levelBytes(steps); ++byte) {
      for (std::size_t i = 0; i < levels.size(); ++i)
        bytes[i] = static_cast<char>(levels[i] >> (8 * byte));
      coder.encodeCharVectorToStream(bytes, stream);
    }
  }

  /** \brief Read levels.
   * \return false if there are more than max_count or they cannot be read
   */
  static bool
  readLevels(std::istream& stream,
             std::vector<std::uint16_t>& levels,
             std::uint32_t steps,
             StaticRangeCoder& coder,
             std::uint64_t max_count)
  {
    const auto count = read<std::uint64_t>(stream);
    if (!stream || count > max_count)
      return false;
    if (count == 0)
      return true;
    std::vector<char> bytes;
    for (int byte = 0; byte < levelBytes(steps); ++byte) {
      if (!hasFrequencyTable(stream))
        return false;
      levels.resize(static_cast<std::size_t>(count), 0);
      bytes.resize(levels.size());
      // does not look at the state of the stream
      coder.decodeStreamToCharVector(stream, bytes);
      if (!stream)
        return false;
      for (std::size_t i = 0; i < levels.size(); ++i)
        levels[i] |= static_cast<std::uint16_t>(static_cast<std::uint8_t>(bytes[i])
                                                << (8 * byte));
    }
    return true;
  }

  /** \brief Whether the next bytes are a frequency table as StaticRangeCoder writes
   * them: 0, then growing to less than 2^16. With others its decoder can divide by 0 or
   * never return. The stream still stands before the table then.
   */
  static bool
  hasFrequencyTable(std::istream& stream)
  {
    std::array<std::uint32_t, 257> table;
    const auto begin = stream.tellg();
    stream.read(reinterpret_cast<char*>(table.data()), sizeof(table));
    if (!stream)
      return false;
    stream.seekg(begin);
    const auto unordered =
        std::adjacent_find(table.begin(), table.end(), std::greater_equal<>());
    return table.front() == 0 && table.back() < (1u << 16) && unordered == table.end();
  }

  /** \brief Fields to encode, with their values in the current frame. */
  std::vector<CodedField> encoded_;

  /** \brief Fields of the current frame that were read but are not decoded yet. */
  std::string block_;

  /** \brief Decoded fields of the current frame. */
  std::vector<CodedField> decoded_;

  /** \brief Most bits of an encoded value. */
  unsigned char bit_depth_{16};
};

} // namespace octree
} // namespace pcl

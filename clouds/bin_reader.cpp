// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/bin_file.h"
#include "clouds/file_text.h"
#include "clouds/point_fields.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace clouds {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kitti_numbers = 4;
constexpr std::size_t nuscenes_numbers = 5;
constexpr std::size_t most_numbers = 10;            ///< of a point of another layout
constexpr std::size_t fewest_certain_numbers = 256; ///< of a file

/** \brief A layout in words. */
std::string
describe(std::size_t numbers)
{
  const std::string points = std::to_string(numbers) + " floats a point";
  switch (numbers) {
  case 3:
    return points + " (x y z)";
  case kitti_numbers:
    return points + " (x y z reflectance, as KITTI's)";
  case nuscenes_numbers:
    return points + " (x y z intensity ring, as nuScenes')";
  case 6:
    return points + " (x y z r g b, or x y z intensity elongation time)";
  default:
    return points;
  }
}

/** \brief The option that names fields, for messages. */
std::string
optionOf(std::size_t numbers)
{
  const std::string option = "--bin-fields " + binFieldsOf(numbers);
  return numbers == 6 ? option + " or x,y,z,intensity,elongation,time" : option;
}

/** \brief The known layouts that a file of so many bytes may have. */
std::string
fittingLayouts(std::size_t bytes)
{
  std::string layouts;
  for (const std::size_t numbers : {3u, 4u, 5u, 6u})
    if (bytes % (numbers * sizeof(float)) == 0)
      layouts += (layouts.empty() ? "; its size would fit " : " or ") +
                 describe(numbers) + ": " + optionOf(numbers);
  return layouts.empty() ? "; --bin-fields names other fields and types" : layouts;
}

/** \brief The layouts that a file may have, the usual ones first: two points may be taken
 * for one, as where the rows of a sensor alternate. */
std::vector<std::size_t>
possibleLayouts(std::size_t likely, std::size_t assumed)
{
  std::vector<std::size_t> layouts;
  for (const std::size_t numbers : {kitti_numbers, nuscenes_numbers, std::size_t{3}})
    if (numbers < likely && numbers != assumed && likely % numbers == 0)
      layouts.push_back(numbers);
  constexpr std::size_t most_usual = 6;
  layouts.insert(likely > most_usual ? layouts.end() : layouts.begin(), likely);
  return layouts;
}

/** \brief Refuses points that are not whole.
 * \param[in] source who tells the fields, in words
 */
void
checkSize(std::size_t bytes,
          const std::vector<FileField>& fields,
          const std::string& source)
{
  const std::uint64_t point_bytes = bytesOf(fields);
  if (bytes % point_bytes != 0)
    fail("it has " + std::to_string(bytes) + " bytes, which is no multiple of " +
         std::to_string(point_bytes) + ": " + source + fittingLayouts(bytes));
}

/** \brief How much numbers differ from those that are so many numbers later, on
 * average, in a scale that is about logarithmic. It is small if both are of the same
 * field. */
double
meanDifference(const std::vector<float>& numbers, std::size_t later)
{
  constexpr double scale = 10.0; // differences below .1 count less
  double sum = 0.0;
  for (std::size_t i = 0; i + later < numbers.size(); ++i)
    sum += std::abs(std::asinh(scale * numbers[i + later]) -
                    std::asinh(scale * numbers[i]));
  return sum / static_cast<double>(numbers.size() - later);
}

/** \brief Whether some in a hundred of the coordinates of points are no lengths.
 * \param[in] are_odd of the numbers of the points
 * \param[in] of_point how many a point has
 * \param[in] checked how many of these are looked at, the first ones
 */
bool
areManyOdd(const std::vector<bool>& are_odd, std::size_t of_point, std::size_t checked)
{
  constexpr std::size_t share = 100;
  std::size_t odd = 0;
  for (std::size_t i = 0; i < are_odd.size(); ++i)
    odd += are_odd[i] && i % of_point < checked;
  return share * odd * of_point > are_odd.size() * checked;
}

/** \brief Whether every so many numbers a point begins, as far as two numbers tell, x and
 * y: their values are about the same in every other point, whatever their order.
 * \param[in] numbers of at least two points
 */
bool
repeatsEvery(std::size_t of_point, const std::vector<float>& numbers)
{
  constexpr float most_different = 0.25f; // of how much values differ from their median
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::vector<float> values[2]; // of even points and odd ones
    for (std::size_t i = axis; i + of_point < numbers.size(); i += 2 * of_point)
      for (std::size_t odd = 0; odd < 2; ++odd)
        values[odd].push_back(numbers[i + odd * of_point]);
    for (std::vector<float>& sorted : values)
      std::sort(sorted.begin(), sorted.end());
    double difference = 0.0;
    double spread = 0.0;
    for (std::size_t i = 0; i < values[0].size(); ++i) {
      difference += std::abs(values[0][i] - values[1][i]);
      spread += std::abs(values[0][i] - values[0][values[0].size() / 2]);
    }
    if (difference > most_different * spread)
      return false;
  }
  return true;
}

/** \brief How many numbers a point has: those of the assumed layout, unless others are
 * clearly more likely. Numbers of the same field of neighbouring points are alike; of
 * points in no order, too, they differ less on average than those of two fields.
 * \param[in] count of numbers in the file
 */
std::size_t
likelyNumbers(const std::vector<float>& numbers,
              const std::vector<bool>& are_odd,
              std::uint64_t count,
              std::size_t assumed)
{
  constexpr std::size_t least_numbers = 64;
  if (numbers.size() < least_numbers)
    return assumed;
  // More than by chance. Of recorded scans those of other layouts differ by 1.2 times as
  // much or more; of files with another layout than assumed, by .6 times as much or less.
  const double clearly =
      1.0 - std::max(0.1, 5.0 / std::sqrt(static_cast<double>(numbers.size())));
  // Those of every other point, too, as the rows of some sensors alternate.
  double least = clearly * std::min(meanDifference(numbers, assumed),
                                    meanDifference(numbers, 2 * assumed));
  std::size_t likely = assumed;
  for (std::size_t candidate = 3; candidate <= most_numbers; ++candidate) {
    if (candidate % assumed == 0 || count % candidate != 0 ||
        areManyOdd(are_odd, candidate, 3))
      continue;
    // A multiple compares the same fields.
    const bool is_multiple = likely != assumed && candidate % likely == 0;
    const double difference = meanDifference(numbers, candidate);
    if (difference < (is_multiple ? clearly : 1.0) * least) {
      least = difference;
      likely = candidate;
    }
  }
  // Two points are alike as one where the rows of a sensor alternate.
  return likely % 2 == 0 && likely / 2 >= 3 && repeatsEvery(likely / 2, numbers)
             ? likely / 2
             : likely;
}

/** \brief The first numbers of a file as floats, and which of them are no lengths. */
struct FirstNumbers {
  explicit FirstNumbers(const std::vector<std::uint8_t>& data)
  {
    constexpr std::size_t most_checked = std::size_t{1} << 18;
    numbers.resize(std::min(data.size() / sizeof(float), most_checked));
    std::memcpy(numbers.data(), data.data(), numbers.size() * sizeof(float));
    for (float& number : numbers) {
      constexpr float largest = 1e9f; // infinity is odd, NaN that of missing points
      are_odd.push_back(std::abs(number) > largest ||
                        std::fpclassify(number) == FP_SUBNORMAL);
      if (!std::isfinite(number))
        number = 0.0f;
    }
  }

  std::vector<float> numbers; ///< 0 where they are not finite
  std::vector<bool> are_odd;
};

/** \brief Which other layout a file has, in words; empty: that which is assumed. */
std::string
otherLayout(const FirstNumbers& first, std::size_t bytes, std::size_t assumed)
{
  if (bytes % sizeof(float) != 0)
    return "";
  const std::size_t likely =
      likelyNumbers(first.numbers, first.are_odd, bytes / sizeof(float), assumed);
  if (likely == assumed)
    return "";
  std::string layouts;
  std::string options;
  for (const std::size_t numbers : possibleLayouts(likely, assumed)) {
    layouts += (layouts.empty() ? "" : ", or of ") + describe(numbers);
    options += (options.empty() ? "" : ", or ") + optionOf(numbers);
  }
  return "its numbers are those of " + layouts + ", not of " + describe(assumed) +
         ": give " + options +
         (options.find('_') == std::string::npos ? ""
                                                 : ", where _ leaves a number out");
}

/** \brief The option for a file of doubles, as text after a message; empty if its
 * numbers are none. */
std::string
optionOfDoubles(const std::vector<std::uint8_t>& data)
{
  constexpr std::size_t most_checked = 1 << 16;
  const std::size_t count = std::min(data.size() / sizeof(double), most_checked);
  std::size_t lengths = 0;
  for (std::size_t i = 0; i < count; ++i) {
    double number;
    std::memcpy(&number, &data[i * sizeof(number)], sizeof(number));
    constexpr double smallest = 1e-12;
    constexpr double largest = 1e9;
    const double length = std::abs(number);
    lengths += length == 0.0 || (length > smallest && length < largest);
  }
  if (100 * lengths < 99 * count || data.size() % sizeof(double) != 0)
    return {};
  const bool has_four = data.size() % (kitti_numbers * sizeof(double)) == 0;
  const bool has_three = data.size() % (3 * sizeof(double)) == 0;
  const std::string three = "x:float64,y:float64,z:float64";
  return !has_three && !has_four
             ? std::string()
             : std::string("; as numbers of 64 bits they are: give --bin-fields ") +
                   (has_four ? three + ",intensity:float64" : "") +
                   (has_four && has_three ? ", or " : "") + (has_three ? three : "");
}

/** \brief Refuses a file that is not in the layout that its name tells. */
void
checkLayout(const std::vector<std::uint8_t>& data, const std::vector<FileField>& fields)
{
  const std::size_t assumed = fields.size();
  const FirstNumbers first(data);
  if (const std::string other = otherLayout(first, data.size(), assumed);
      !other.empty())
    fail(other);
  checkSize(data.size(), fields, "by its name it has " + describe(assumed));
  if (areManyOdd(first.are_odd, assumed, assumed))
    fail("its numbers are no lengths and intensities: by its name it has " +
         describe(assumed) +
         ", each a little-endian float32; --bin-fields names other fields and types" +
         optionOfDoubles(data));
}

/** \brief Checks a file for the layout that the user gives.
 * \return that it looks like one of another layout
 */
std::vector<std::string>
checkGivenLayout(const std::vector<std::uint8_t>& data,
                 const std::vector<FileField>& fields)
{
  checkSize(data.size(),
            fields,
            "--bin-fields has " + std::to_string(bytesOf(fields)) + " bytes a point");
  if (!std::all_of(fields.begin(), fields.end(), [](const FileField& field) {
        return field.bytes == sizeof(float) &&
               (field.kind == FieldKind::Real || field.kind == FieldKind::Ignored);
      }))
    return {};
  const std::string other = otherLayout(FirstNumbers(data), data.size(), fields.size());
  return other.empty()
             ? std::vector<std::string>()
             : std::vector<std::string>{"--bin-fields may be wrong: " + other};
}

} // namespace

std::vector<std::string>
readBin(const std::string& path,
        const std::vector<FileField>& given,
        pcl::PCLPointCloud2& cloud)
{
  const std::uint64_t bytes = fs::file_size(path);
  constexpr std::uint64_t most_bytes = std::uint64_t{1} << 30;
  if (bytes > most_bytes)
    fail("it has " + std::to_string(bytes) +
         " bytes, which is too many for a cloud of a lidar");
  std::vector<std::uint8_t> data(bytes);
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(data.data()),
                 static_cast<std::streamsize>(bytes)))
    fail("reading it failed");
  const std::vector<FileField> fields =
      !given.empty() ? given
                     : parseBinFields(binFieldsOf(
                           hasNuScenesName(path) ? nuscenes_numbers : kitti_numbers));
  toLittleEndian(fields, data);
  std::vector<std::string> remarks;
  if (given.empty()) {
    checkLayout(data, fields);
    if (data.size() < fewest_certain_numbers * sizeof(float))
      remarks.push_back("it is taken as " + describe(fields.size()) +
                        "; its numbers are too few to tell another layout, which "
                        "--bin-fields names");
  }
  else
    remarks = checkGivenLayout(data, fields);
  startCloud(fields, bytes / bytesOf(fields), 1, cloud);
  cloud.data = std::move(data);
  return remarks;
}

} // namespace clouds
} // namespace pcl_ext

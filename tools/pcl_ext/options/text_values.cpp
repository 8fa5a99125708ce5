// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/text_values.h"

#include <pcl_ext/intensity/intensity_law.h>

#include "console/exit_status.h"
#include "measuring/markdown_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <utility>

namespace pcl_ext::tools {

namespace {

/** \brief Checks how many numbers an option has. */
void
expectCount(const std::string& option,
            const std::vector<double>& numbers,
            std::size_t count,
            const std::string& names = {})
{
  if (numbers.size() != count)
    throw UsageError("--" + option + " needs " + std::to_string(count) + " numbers, " +
                     names + (names.empty() ? "" : ", ") + "not " +
                     std::to_string(numbers.size()));
}

Eigen::Isometry3d
poseOfAngles(const std::vector<double>& numbers)
{
  constexpr double radians = 3.14159265358979323846 / 180.0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(numbers[0], numbers[1], numbers[2]));
  pose.rotate(Eigen::AngleAxisd(radians * numbers[5], Eigen::Vector3d::UnitZ()) *
              Eigen::AngleAxisd(radians * numbers[4], Eigen::Vector3d::UnitY()) *
              Eigen::AngleAxisd(radians * numbers[3], Eigen::Vector3d::UnitX()));
  return pose;
}

Eigen::Isometry3d
poseOfQuaternion(const std::vector<double>& numbers)
{
  const Eigen::Quaterniond rotation(numbers[6], numbers[3], numbers[4], numbers[5]);
  constexpr double tolerance = 1e-2; // quaternions are often written with few digits
  if (std::abs(rotation.norm() - 1.0) > tolerance)
    throw UsageError("--pose: qx,qy,qz,qw has the length " +
                     std::to_string(rotation.norm()) + "; it must be 1");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(numbers[0], numbers[1], numbers[2]));
  pose.rotate(rotation.normalized());
  return pose;
}

Eigen::Isometry3d
poseOfMatrix(const std::vector<double>& numbers)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      pose(row, column) = numbers[static_cast<std::size_t>(4 * row + column)];
  const bool has_last_row = numbers.size() == 16;
  if (!isRigid(pose.cast<float>()) ||
      (has_last_row && (numbers[12] != 0.0 || numbers[13] != 0.0 ||
                        numbers[14] != 0.0 || numbers[15] != 1.0)))
    throw UsageError("--pose: the matrix is not a rotation and a translation");
  return pose;
}

std::string
lowerCase(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return text;
}

/** \brief Reads a number above 0 and one of some units, in any case.
 * \param[in] option for messages
 * \param[in] example a valid text
 * \param[in] may_be_zero whether 0 is a number, too
 */
double
parseQuantity(const std::string& option,
              const std::string& text,
              const std::vector<std::pair<std::string, double>>& units,
              const std::string& example,
              bool may_be_zero = false)
{
  const std::string fault = option + ": '" + text + "' ";
  const std::string remedy = "; " + example + " is one";
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || !std::isfinite(number))
    throw UsageError(fault + "is no number with a unit" + remedy);
  std::string unit(end);
  unit.erase(0, std::min(unit.find_first_not_of(' '), unit.size()));
  const auto found =
      std::find_if(units.begin(), units.end(), [&unit](const auto& known) {
        return lowerCase(unit) == lowerCase(known.first);
      });
  if (found == units.end()) {
    std::string known;
    for (const auto& one : units)
      known += (known.empty() ? "" : ", ") + one.first;
    throw UsageError(fault +
                     (unit.empty() ? "has no unit" : "has none of the units " + known) +
                     remedy);
  }
  if (!(number > 0.0 || (may_be_zero && number == 0.0)))
    throw UsageError(fault + (may_be_zero ? "is below 0" : "is not above 0") + remedy);
  return number * found->second;
}

std::size_t
parseFrameNumber(const std::string& text)
{
  constexpr std::size_t most_digits = 18;
  if (text.empty() || text.size() > most_digits ||
      text.find_first_not_of("0123456789") != std::string::npos)
    throw UsageError("--frames: '" + text + "' is not the number of a frame");
  return std::stoull(text);
}

} // namespace

std::vector<double>
parseNumbers(const std::string& option, const std::string& text)
{
  std::vector<double> numbers;
  std::string separated = text;
  std::replace(separated.begin(), separated.end(), ',', ' ');
  std::istringstream stream(separated);
  std::string word;
  while (stream >> word) {
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    if (*end != '\0')
      throw UsageError("--" + option + ": '" + word + "' is not a number");
    if (!std::isfinite(numbers.back()))
      throw UsageError("--" + option + ": '" + word + "' is not a finite number");
  }
  return numbers;
}

std::vector<double>
parseNumbers(const std::string& option, const std::string& text, std::size_t count)
{
  std::vector<double> numbers = parseNumbers(option, text);
  expectCount(option, numbers, count);
  return numbers;
}

io::BoundingBox
parseBox(const std::string& option, const std::string& text)
{
  const std::vector<double> corners = parseNumbers(option, text);
  expectCount(option, corners, 6, "x0,y0,z0,x1,y1,z1");
  io::BoundingBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = corners[axis];
    box.max[axis] = corners[axis + 3];
    if (box.min[axis] >= box.max[axis])
      throw UsageError("--" + option +
                       ": on each axis the first corner must be below "
                       "the second one");
  }
  return box;
}

std::array<double, 3>
parsePosition(const std::string& option, const std::string& text)
{
  const std::vector<double> numbers = parseNumbers(option, text);
  expectCount(option, numbers, 3, "x,y,z");
  return {numbers[0], numbers[1], numbers[2]};
}

RuntimeSensor
parseSensor(const std::string& text)
{
  if (text.find(',') == std::string::npos) {
    if (const auto sensor = valueNamed(named_sensors, text))
      return *sensor;
    throw UsageError("--sensor: unknown sensor '" + text +
                     "'; known: " + namesOf(named_sensors) +
                     "; others: horizontal degrees,vertical degrees,columns,rows");
  }
  const std::vector<double> figures = parseNumbers("sensor", text);
  expectCount("sensor", figures, 4, "horizontal degrees,vertical degrees,columns,rows");
  const auto pixels = [](double number) {
    constexpr double most = 65536.0;
    if (!(number >= 1.0 && number <= most) || number != std::floor(number))
      throw UsageError("--sensor: columns and rows are whole numbers, 1 to 65536");
    return static_cast<unsigned int>(number);
  };
  try {
    return RuntimeSensor(
        figures[0], figures[1], pixels(figures[2]), pixels(figures[3]));
  }
  catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--sensor: ") + error.what());
  }
}

WorldPose
parsePose(const std::string& text)
{
  const std::vector<double> numbers = parseNumbers("pose", text);
  switch (numbers.size()) {
  case 6:
    return WorldPose(poseOfAngles(numbers));
  case 7:
    return WorldPose(poseOfQuaternion(numbers));
  case 12:
  case 16:
    return WorldPose(poseOfMatrix(numbers));
  default:
    throw UsageError("--pose has " + std::to_string(numbers.size()) +
                     " numbers; it needs x,y,z,roll,pitch,yaw (metres, degrees), "
                     "x,y,z,qx,qy,qz,qw, or the 12 or 16 of a matrix, row by row");
  }
}

double
parseRate(const std::string& text)
{
  if (text == "0")
    return 0.0; // no limit
  return parseQuantity(
      "--max-rate",
      text,
      {{"bit/s", 1.0}, {"kbit/s", 1e3}, {"Mbit/s", 1e6}, {"Gbit/s", 1e9}},
      "500kbit/s or 2Mbit/s");
}

double
parseDuration(const std::string& option, const std::string& text, bool may_be_zero)
{
  constexpr double longest = 36'500.0 * 86'400.0; // nanoseconds have 63 bits
  const double seconds = parseQuantity(
      option,
      text,
      {{"ms", 1e-3}, {"s", 1.0}, {"min", 60.0}, {"h", 3600.0}, {"d", 86400.0}},
      "10min",
      may_be_zero);
  if (seconds > longest)
    throw UsageError(option + ": '" + text + "' is above 36500d");
  return seconds;
}

double
parseSeconds(const std::string& option, const std::string& text)
{
  char* end = nullptr;
  const double seconds = std::strtod(text.c_str(), &end);
  return end != text.c_str() && *end == '\0' ? seconds : parseDuration(option, text);
}

double
parseBytes(const std::string& option, const std::string& text)
{
  constexpr double most = 1e18;
  const double bytes = parseQuantity(
      option, text, {{"kB", 1e3}, {"MB", 1e6}, {"GB", 1e9}, {"TB", 1e12}}, "2GB");
  if (bytes > most)
    throw UsageError(option + ": '" + text + "' is above 1000000TB");
  return bytes;
}

std::string
inOrder(const io::FrameDescription& frame)
{
  const std::string size =
      std::to_string(frame.scan.width) + " x " + std::to_string(frame.scan.height);
  const std::string order = frame.is_row_by_row ? "row by row" : "in order";
  if (frame.is_organised)
    return order + ", " + size + (frame.has_rays ? "" : ", without rays");
  return order + (frame.has_rays ? ", on " + size + " rays" : ", without rays");
}

std::string
counted(std::size_t count, const std::string& noun)
{
  return measuring::formatted(static_cast<double>(count), 0) + ' ' + noun +
         (count == 1 ? "" : "s");
}

FrameRange
parseFrames(const std::string& text)
{
  FrameRange range;
  const std::size_t colon = text.find(':');
  if (colon != 0)
    range.begin = parseFrameNumber(text.substr(0, colon));
  if (colon == std::string::npos)
    range.end = range.begin + 1;
  else if (colon + 1 < text.size())
    range.end = parseFrameNumber(text.substr(colon + 1));
  if (range.begin >= range.end)
    throw UsageError("--frames " + text +
                     " is no frame; A:B is the frames A to B - 1, "
                     "counted from 0");
  return range;
}

} // namespace pcl_ext::tools

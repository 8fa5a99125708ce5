// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/filters/lidar_clouds.h>

#include "codec/scan/scan_frame.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <locale>
#include <sstream>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

/** \brief A point of a cloud, and when and by which laser it was measured. */
struct MeasuredPoint {
  double time;
  double ring;
  const std::uint8_t* bytes; // point_step of them

  bool
  operator<(const MeasuredPoint& other) const
  {
    return std::pair(time, ring) < std::pair(other.time, other.ring);
  }
};

PreprocessingStatus
invalidField(const std::string& what)
{
  return {PreprocessingCode::InvalidField, what};
}

/** \brief Finds a field of one value.
 * \param[in] name, or empty
 * \param[in] usual names, of which the first one that there is counts
 */
PreprocessingStatus
findOrderField(const pcl::PCLPointCloud2& cloud,
               const std::string& name,
               std::initializer_list<const char*> usual,
               FoundField& found)
{
  std::vector<std::string> names(usual.begin(), usual.end());
  if (!name.empty())
    names = {name};
  const std::vector<FoundField> fields = findFields(cloud);
  std::string list;
  for (const std::string& wanted : names) {
    const auto field =
        std::find_if(fields.begin(), fields.end(), [&](const FoundField& candidate) {
          return candidate.description.name == wanted;
        });
    if (field == fields.end()) {
      list += (list.empty() ? "'" : ", '") + wanted + "'";
      continue;
    }
    found = *field;
    if (found.description.count == 1)
      return {};
    return invalidField("field '" + wanted + "' has " +
                        std::to_string(found.description.count) +
                        " values a point; it must have one");
  }
  return {PreprocessingCode::MissingField, "the cloud has no field " + list};
}

double
numberAt(const FoundField& field, const std::uint8_t* point)
{
  return io::fieldValue(field.description,
                        io::fieldNumber(field.description, point + field.offset));
}

/** \brief Reads the points of a cloud and sorts them by time and ring. */
PreprocessingStatus
readPoints(const pcl::PCLPointCloud2& cloud,
           const OrderFields& fields,
           std::vector<MeasuredPoint>& points)
{
  PointLayout layout;
  if (PreprocessingStatus status = findPointLayout(cloud, "", false, false, layout);
      !status.ok())
    return status;
  if (!areReal(layout.types))
    return invalidField("coordinates must be FLOAT32, or FLOAT64, as those of missing "
                        "points are NaN");
  FoundField time;
  FoundField ring;
  if (PreprocessingStatus status =
          findOrderField(cloud,
                         fields.time,
                         {"t", "time", "timestamp", "time_stamp", "offset_time"},
                         time);
      !status.ok())
    return status;
  if (PreprocessingStatus status =
          findOrderField(cloud, fields.ring, {"ring", "channel", "line"}, ring);
      !status.ok())
    return status;
  const std::size_t row_step = rowStep(cloud);
  for (std::size_t row = 0; row < cloud.height; ++row)
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const std::uint8_t* const point =
          cloud.data.data() + row * row_step + column * cloud.point_step;
      if (!detail::readPoint<double>(point, layout).allFinite())
        continue;
      points.push_back({numberAt(time, point), numberAt(ring, point), point});
      if (std::isnan(points.back().time) || std::isnan(points.back().ring))
        return invalidField(
            "field '" +
            (std::isnan(points.back().time) ? time : ring).description.name +
            "' of a point is not a number");
    }
  std::stable_sort(points.begin(), points.end());
  return {};
}

/** \brief A point without coordinates. */
std::vector<std::uint8_t>
missingPoint(const pcl::PCLPointCloud2& cloud)
{
  std::vector<std::uint8_t> point(cloud.point_step);
  const auto fill = [&](const pcl::PCLPointField& field, auto number) {
    for (std::uint64_t i = 0; i < std::max<std::uint64_t>(field.count, 1); ++i)
      if (const std::uint64_t at = field.offset + i * sizeof(number);
          at + sizeof(number) <= point.size())
        std::memcpy(&point[at], &number, sizeof(number));
  };
  for (const pcl::PCLPointField& field : cloud.fields) {
    if (field.datatype == pcl::PCLPointField::FLOAT32)
      fill(field, std::numeric_limits<float>::quiet_NaN());
    else if (field.datatype == pcl::PCLPointField::FLOAT64)
      fill(field, std::numeric_limits<double>::quiet_NaN());
  }
  return point;
}

void
setPoints(pcl::PCLPointCloud2& cloud,
          std::vector<std::uint8_t>&& data,
          std::size_t width,
          std::size_t height,
          bool is_dense)
{
  cloud.data = std::move(data);
  cloud.width = static_cast<std::uint32_t>(width);
  cloud.height = static_cast<std::uint32_t>(height);
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.is_dense = is_dense ? 1 : 0;
}

/** \brief Columns of the times of points, from 0 on.
 * \param[in] points sorted by time
 * \return empty if most points have a time of their own
 */
std::vector<double>
columnsOf(const std::vector<MeasuredPoint>& points)
{
  std::vector<double> gaps;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i].time != points[i - 1].time)
      gaps.push_back(points[i].time - points[i - 1].time);
  if (2 * (gaps.size() + 1) > points.size())
    return {};
  double period = 1.0;
  if (!gaps.empty()) {
    const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
    std::nth_element(gaps.begin(), middle, gaps.end());
    const double about = *middle;
    // Their mean is exact where times are rounded.
    double sum = 0.0;
    double count = 0.0;
    for (const double gap : gaps)
      if (gap < 1.5 * about) {
        sum += gap;
        ++count;
      }
    period = sum / count;
  }
  std::vector<double> columns = {0.0};
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double gap = points[i].time - points[i - 1].time;
    columns.push_back(columns.back() +
                      (gap > 0.0 ? std::max(1.0, std::round(gap / period)) : 0.0));
  }
  return columns;
}

/** \brief Finds how many rows and columns points need.
 * \param[in] points sorted by column
 * \param[in,out] image 0: as many as needed
 */
PreprocessingStatus
fitImage(const std::vector<MeasuredPoint>& points,
         const std::vector<double>& columns,
         io::ImageSize& image)
{
  double width = 0.0;
  double height = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double ring = points[i].ring;
    if (!(ring >= 0.0) || ring != std::floor(ring))
      return invalidField("the ring of a point is " + std::to_string(ring) +
                          "; it must be a whole number from 0 on");
    width = std::max(width, columns[i] + 1.0);
    height = std::max(height, ring + 1.0);
  }
  const double most_columns = image.width > 0 ? image.width : io::scan::most_side;
  const double most_rows = image.height > 0 ? image.height : io::scan::most_side;
  if (width > most_columns || height > most_rows) {
    std::ostringstream what;
    what.imbue(std::locale::classic());
    what << "the points need " << width << " columns and " << height
         << " rows; there may be " << most_columns << " and " << most_rows;
    return {PreprocessingCode::InvalidLayout, what.str()};
  }
  if (image.width == 0)
    image.width = static_cast<std::uint32_t>(width);
  if (image.height == 0)
    image.height = static_cast<std::uint32_t>(height);
  if (std::uint64_t{image.width} * image.height > io::scan::most_pixels)
    return {PreprocessingCode::InvalidLayout,
            std::to_string(image.width) + " columns and " +
                std::to_string(image.height) + " rows are more than " +
                std::to_string(io::scan::most_pixels) + " pixels"};
  return {};
}

} // namespace

PreprocessingStatus
sortByTime(pcl::PCLPointCloud2& cloud, const OrderFields& fields)
{
  std::vector<MeasuredPoint> points;
  if (PreprocessingStatus status = readPoints(cloud, fields, points); !status.ok())
    return status;
  std::vector<std::uint8_t> data;
  data.reserve(points.size() * cloud.point_step);
  for (const MeasuredPoint& point : points)
    data.insert(data.end(), point.bytes, point.bytes + cloud.point_step);
  setPoints(cloud, std::move(data), points.size(), 1, true);
  return {};
}

PreprocessingStatus
arrangeByRing(pcl::PCLPointCloud2& cloud,
              const io::ImageSize& size,
              const OrderFields& fields)
{
  std::vector<MeasuredPoint> points;
  if (PreprocessingStatus status = readPoints(cloud, fields, points); !status.ok())
    return status;
  const std::vector<double> columns = columnsOf(points);
  if (columns.size() < points.size())
    return invalidField("most points have a time of their own: there are no columns of "
                        "points of the same time");
  io::ImageSize image = size;
  if (PreprocessingStatus status = fitImage(points, columns, image); !status.ok())
    return status;
  const std::size_t pixels = std::size_t{image.width} * image.height;
  const std::vector<std::uint8_t> missing = missingPoint(cloud);
  std::vector<std::uint8_t> data;
  data.reserve(pixels * missing.size());
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    data.insert(data.end(), missing.begin(), missing.end());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0 && columns[i] == columns[i - 1] && points[i].ring == points[i - 1].ring)
      return invalidField("two points have the same ring and time");
    const std::size_t pixel = static_cast<std::size_t>(points[i].ring) * image.width +
                              static_cast<std::size_t>(columns[i]);
    std::copy_n(points[i].bytes, missing.size(), data.begin() + pixel * missing.size());
  }
  setPoints(cloud, std::move(data), image.width, image.height, points.size() == pixels);
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI

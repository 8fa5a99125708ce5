// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/made_fields.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace pcl_ext {
namespace clouds {

const pcl::PCLPointField*
findField(const pcl::PCLPointCloud2& cloud, const std::string& name)
{
  const auto found = std::find_if(
      cloud.fields.begin(), cloud.fields.end(), [&name](const auto& field) {
        return field.name == name && field.count == 1;
      });
  return found == cloud.fields.end() ? nullptr : &*found;
}

double
NumberReader::operator()(const std::uint8_t* point) const
{
  return visitNumber(file_field_, point + offset_, [](auto number) {
    return static_cast<double>(number);
  });
}

MadeField
copyOf(const pcl::PCLPointField& field)
{
  const FileField of_file = fileFieldOf(field);
  return {field, of_file.bytes * of_file.count, nullptr};
}

void
setFields(std::vector<MadeField>& fields, pcl::PCLPointCloud2& cloud)
{
  // Fields that are copied and are neighbours in both clouds are copied at once.
  std::vector<std::function<void(const std::uint8_t*, std::uint8_t*)>> steps;
  std::size_t step = 0;
  for (std::size_t i = 0; i < fields.size();) {
    const std::size_t to = step;
    if (fields[i].make) {
      steps.push_back([to, make = fields[i].make](const auto* point, auto* made) {
        make(point, made + to);
      });
      fields[i].field.offset = static_cast<std::uint32_t>(step);
      step += fields[i++].bytes;
      continue;
    }
    const std::size_t from = fields[i].field.offset;
    for (; i < fields.size() && !fields[i].make &&
           fields[i].field.offset == from + (step - to);
         ++i) {
      fields[i].field.offset = static_cast<std::uint32_t>(step);
      step += fields[i].bytes;
    }
    steps.push_back([from, to, bytes = step - to](const auto* point, auto* made) {
      std::memcpy(made + to, point + from, bytes);
    });
  }
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  std::vector<std::uint8_t> data(points * step);
  for (std::size_t i = 0; i < points; ++i)
    for (const auto& make : steps)
      make(&cloud.data[i * cloud.point_step], &data[i * step]);
  cloud.fields.clear();
  for (MadeField& made : fields)
    cloud.fields.push_back(std::move(made.field));
  cloud.point_step = static_cast<std::uint32_t>(step);
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.data = std::move(data);
}

} // namespace clouds
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/field_collector.h"

#include "voxels/field_summary.h"
#include "voxels/radix_sort.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <locale>
#include <sstream>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

std::string
listOf(const std::vector<FieldDescription>& fields)
{
  std::string list;
  for (const FieldDescription& field : fields)
    list += (list.empty() ? "'" : ", '") + field.name + "'";
  return list.empty() ? "none" : list;
}

/** \brief Appends the values of some points of a batch. */
void
readField(const FieldView& view,
          const FieldDescription& description,
          const std::vector<std::uint32_t>& indices,
          std::vector<std::uint64_t>& numbers)
{
  const auto* const first = static_cast<const unsigned char*>(view.first);
  const std::size_t size = sizeOf(description.type);
  for (const std::uint32_t point : indices)
    for (std::size_t k = 0; k < description.count; ++k)
      numbers.push_back(
          fieldNumber(description, first + point * view.stride + k * size));
}

/** \brief Why a field cannot be kept; empty if it can. */
std::string
faultOf(const FieldDescription& field)
{
  std::ostringstream fault;
  fault.imbue(std::locale::classic());
  if (field.name.empty() || field.name.size() > most_field_name_bytes)
    fault << "its name has " << field.name.size() << " bytes; it must have 1 to "
          << most_field_name_bytes;
  else if (field.count < 1 || field.count > most_field_values)
    fault << "a point has " << field.count << " values of it; it must have 1 to "
          << most_field_values;
  else if (isInteger(field.type) && std::floor(field.step) != field.step)
    fault << "its values are integers and its step is " << field.step
          << "; it must be a whole number, or 0 for exact values";
  else if (isPackedColour(field) && field.step != 0.0)
    fault << "it is a packed colour and its step is " << field.step
          << "; it must be 0, as the bytes of a colour are no number to round";
  else if (field.type < FieldType::Int8 || field.type > FieldType::Float64)
    fault << "its datatype is none of int8 to uint32, float32 and float64";
  else if (!isField(field))
    fault << "its step is " << field.step << "; it must be finite, and 0 or above";
  return fault.str();
}

/** \brief Names of fields that all_fields stands for and that cannot be kept. */
std::string
namesOfLeftOut(const std::vector<FieldDescription>& offered)
{
  constexpr std::size_t most_named = 16;
  std::vector<FieldDescription> left_out;
  for (const FieldDescription& field : offered)
    if (!isField(field))
      left_out.push_back(field);
  const bool are_many = left_out.size() > most_named;
  left_out.resize(std::min(left_out.size(), most_named));
  return left_out.empty() ? std::string()
                          : listOf(left_out) + (are_many ? ", ..." : "");
}

} // namespace

bool
FieldCollector::meansAll() const
{
  return std::any_of(settings_.begin(), settings_.end(), [](const FieldSetting& field) {
    return field.name == all_fields;
  });
}

CompressionStatus
FieldCollector::select(const std::vector<FieldDescription>& offered, bool of_voxels)
{
  selected_.clear();
  const auto add = [&](std::size_t index, double step) {
    const auto is_same = [index](const Selected& other) {
      return other.index == index;
    };
    if (std::any_of(selected_.begin(), selected_.end(), is_same))
      return;
    selected_.push_back({offered[index], index});
    selected_.back().description.step = step;
  };
  bool are_all = false;
  for (const FieldSetting& setting : settings_) {
    // Also where a field has this name, which is one of them.
    if (setting.name == all_fields) {
      are_all = true;
      continue;
    }
    const auto found = std::find_if(
        offered.begin(), offered.end(), [&setting](const FieldDescription& field) {
          return field.name == setting.name;
        });
    if (found == offered.end())
      return {CompressionCode::InvalidInput,
              "the cloud has no field '" + setting.name +
                  "' to keep; it has: " + listOf(offered)};
    add(static_cast<std::size_t>(found - offered.begin()), setting.step);
  }
  left_out_ = are_all ? namesOfLeftOut(offered) : std::string();
  for (std::size_t index = 0; are_all && index < offered.size(); ++index)
    if (isOneOfAllFields(offered[index],
                         codes_colours_ && !(of_voxels && keeps_points_)))
      add(index, 0.0);
  loses_alpha_ =
      are_all && hasField(offered, "rgba") &&
      std::none_of(selected_.begin(), selected_.end(), [](const Selected& field) {
        return field.description.name == "rgba";
      });
  std::size_t values = 0;
  for (const Selected& field : selected_) {
    if (const std::string fault = faultOf(field.description); !fault.empty())
      return {CompressionCode::InvalidInput,
              "field '" + field.description.name + "' cannot be kept: " + fault};
    values += field.description.count;
  }
  if (selected_.size() > most_fields || values > most_field_values)
    return {CompressionCode::InvalidInput,
            "too many fields: " + std::to_string(selected_.size()) + " with " +
                std::to_string(values) + " values a point; at most " +
                std::to_string(most_fields) + " with " +
                std::to_string(most_field_values) + " values can be kept"};
  return {};
}

CompressionStatus
FieldCollector::collect(PointBatches& points,
                        const VoxelLocator& locator,
                        VoxelFrame& frame)
{
  entries_.clear();
  numbers_.resize(selected_.size());
  for (std::vector<std::uint64_t>& numbers : numbers_)
    numbers.clear();
  points.restart();
  for (PointView batch; points.next(batch);)
    readBatch(batch, locator, !frame.has_point_counts);
  radixSort(entries_, spare_, 3 * frame.grid.depth);
  if (frame.has_point_counts)
    sortPointsOfVoxels();
  frame.fields.resize(selected_.size());
  for (std::size_t i = 0; i < selected_.size(); ++i) {
    FrameField& field = frame.fields[i];
    static_cast<FieldDescription&>(field) = selected_[i].description;
    if (frame.has_point_counts)
      arrange(i, field);
    else
      summarize(i, field);
    if (CompressionStatus status = checkNumbers(field); !status.ok())
      return status;
  }
  return {};
}

CompressionStatus
checkNumbers(const FrameField& field)
{
  const bool is_clamped = std::any_of(
      field.numbers.begin(), field.numbers.end(), [&field](std::uint64_t number) {
        return isFieldNumberClamped(field, number);
      });
  if (!is_clamped)
    return {};
  return {CompressionCode::InvalidInput,
          "field '" + field.name +
              "' has a value of 2^52 steps or more: it needs a larger step, or none"};
}

/** \brief Puts the numbers of a field in the order of the voxels. */
void
FieldCollector::arrange(std::size_t field, FrameField& arranged) const
{
  const std::size_t count = arranged.count;
  arranged.numbers.resize(entries_.size() * count);
  auto next = arranged.numbers.begin();
  for (const Entry& entry : entries_)
    next = std::copy_n(numbers_[field].begin() +
                           static_cast<std::ptrdiff_t>(entry.point * count),
                       count,
                       next);
}

void
FieldCollector::readBatch(const PointView& points,
                          const VoxelLocator& locator,
                          bool of_voxels)
{
  VoxelizationStatistics statistics; // counted before
  for (std::size_t i = 0; i < points.count; i += LocatedPoints::capacity) {
    locator.find(points, i, located_, statistics);
    batch_.clear();
    for (std::size_t k = 0; k < located_.count; ++k) {
      entries_.push_back({mortonKey(BlockVoxel{located_.blocks[k], located_.voxels[k]}),
                          static_cast<std::uint32_t>(entries_.size())});
      batch_.push_back(static_cast<std::uint32_t>(located_.points[k]));
    }
    for (std::size_t k = 0; k < selected_.size(); ++k) {
      FieldDescription description = selected_[k].description;
      if (of_voxels)
        description.step = 0.0; // rounded once, as what is made of them
      readField(points.fields[selected_[k].index], description, batch_, numbers_[k]);
    }
  }
}

void
FieldCollector::readPoints(const PointView& points,
                           const std::vector<std::uint32_t>& indices,
                           std::vector<std::vector<std::uint64_t>>& numbers) const
{
  for (std::size_t k = 0; k < selected_.size(); ++k)
    readField(points.fields[selected_[k].index],
              selected_[k].description,
              indices,
              numbers[k]);
}

/** \brief Sorts the points of each voxel by their first field, which then ascends. */
void
FieldCollector::sortPointsOfVoxels()
{
  if (selected_.empty())
    return;
  const std::size_t count = selected_.front().description.count;
  const std::vector<std::uint64_t>& numbers = numbers_.front();
  const auto is_lower = [&](const Entry& one, const Entry& other) {
    return numbers[one.point * count] < numbers[other.point * count];
  };
  for (auto begin = entries_.begin(); begin != entries_.end();) {
    auto end = begin + 1;
    while (end != entries_.end() && end->key == begin->key)
      ++end;
    if (end - begin > 1)
      std::stable_sort(begin, end, is_lower);
    begin = end;
  }
}

/** \brief Makes one value of those of each voxel: the mean, or of integers the most
 * frequent; several integers of a point stay together, as two of 32 bits are one of
 * 64. */
void
FieldCollector::summarize(std::size_t field, FrameField& summary)
{
  FieldDescription exact = summary;
  exact.step = 0.0;
  const std::vector<std::uint64_t>& numbers = numbers_[field];
  const bool stay_together = exact.count > 1 && isInteger(exact.type);
  std::vector<std::vector<std::uint64_t>> of_points;
  const auto add = [&](std::uint64_t number) {
    std::array<unsigned char, 8> value{};
    fieldValue(exact, number, value.data());
    summary.numbers.push_back(fieldNumber(summary, value.data()));
  };
  summary.numbers.clear();
  for (std::size_t begin = 0, end = 0; begin < entries_.size(); begin = end) {
    while (end < entries_.size() && entries_[end].key == entries_[begin].key)
      ++end;
    if (stay_together) {
      of_points.clear();
      for (std::size_t i = begin; i < end; ++i) {
        const auto first = numbers.begin() +
                           static_cast<std::ptrdiff_t>(entries_[i].point * exact.count);
        of_points.emplace_back(first, first + exact.count);
      }
      for (const std::uint64_t number : mostFrequent(of_points))
        add(number);
      continue;
    }
    for (std::size_t k = 0; k < exact.count; ++k) {
      of_voxel_.clear();
      for (std::size_t i = begin; i < end; ++i)
        of_voxel_.push_back(numbers[entries_[i].point * exact.count + k]);
      std::array<unsigned char, 8> value{};
      summarizeField(exact, of_voxel_, value.data());
      summary.numbers.push_back(fieldNumber(summary, value.data()));
    }
  }
}

void
FieldCollector::releaseMemory()
{
  entries_ = std::vector<Entry>();
  spare_ = std::vector<Entry>();
  numbers_.clear();
  of_voxel_ = std::vector<std::uint64_t>();
  batch_ = std::vector<std::uint32_t>();
}

} // namespace pcl_ext::PCL_EXT_ABI::io

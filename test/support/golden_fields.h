// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/golden_stream.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief Numbers of points of 1 to 4; most voxels have one. */
inline void
addFewPointCounts(std::mt19937_64& random, VoxelFrame& frame)
{
  frame.has_point_counts = true;
  frame.point_counts.clear();
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const bool has_one = below(random, 2) == 0;
    frame.point_counts.push_back(
        has_one ? 1 : static_cast<std::uint32_t>(1 + below(random, 4)));
  }
}

/** \brief The number of a value whose bits are the lowest of some. */
inline std::uint64_t
fieldNumberOfBits(const FieldDescription& field, std::uint64_t bits)
{
  const auto number = [&](auto typed_bits) {
    typed_bits = static_cast<decltype(typed_bits)>(bits);
    return fieldNumber(field, &typed_bits);
  };
  switch (sizeOf(field.type)) {
  case 1:
    return number(std::uint8_t{});
  case 2:
    return number(std::uint16_t{});
  case 4:
    return number(std::uint32_t{});
  default:
    return number(std::uint64_t{});
  }
}

/** \brief Adds a field to a frame.
 * \param[in] bits_of gives the bits of a value, for the position of its voxel from the
 * viewpoint
 */
template <typename BitsOfT>
void
addField(const FieldDescription& description, VoxelFrame& frame, BitsOfT&& bits_of)
{
  FrameField field;
  static_cast<FieldDescription&>(field) = description;
  for (std::size_t voxel = 0; voxel < frame.size(); ++voxel) {
    const VoxelPosition position = voxelPosition(frame.keys[voxel]);
    const std::array<std::int64_t, 3> from_viewpoint = {
        std::int64_t{position.x} - frame.viewpoint[0],
        std::int64_t{position.y} - frame.viewpoint[1],
        std::int64_t{position.z} - frame.viewpoint[2]};
    const std::size_t points = frame.has_point_counts ? frame.point_counts[voxel] : 1;
    for (std::size_t i = 0; i < points * description.count; ++i)
      field.numbers.push_back(
          fieldNumberOfBits(description, bits_of(from_viewpoint, i)));
  }
  frame.fields.push_back(std::move(field));
}

inline std::uint64_t
bitsOf(double value)
{
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

inline std::uint64_t
bitsOf(float value)
{
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof(bits));
  return bits;
}

/** \brief The ring of a lidar at a position from it: it grows with the elevation. */
inline std::uint64_t
ringAt(const std::array<std::int64_t, 3>& position)
{
  const std::int64_t distance = 1 + std::abs(position[0]) + std::abs(position[1]);
  return static_cast<std::uint64_t>(64 + position[2] * 48 / distance);
}

/** \brief Which values the field "few" has, in a stream of them. */
enum class FewValues { Few, OtherFew, Many };

/** \brief Fields of a lidar's points, and some of other values.
 * \param[in] time of the frame
 */
inline void
addLidarFields(std::mt19937_64& random,
               std::uint64_t time,
               FewValues few_values,
               VoxelFrame& frame)
{
  using Position = std::array<std::int64_t, 3>;
  frame.fields.clear();
  addField({"ring", FieldType::UInt16}, frame, [&](const Position& at, std::size_t) {
    return ringAt(at) + (below(random, 16) == 0 ? below(random, 5) : 0);
  });
  // Exact, in a range far wider than their number.
  constexpr float first[] = {-2.5e20f, -1.0f, 0.0f, 0.001f, 1.0f, 7.0f, 1.0e9f};
  addField({"few", FieldType::Float32}, frame, [&](const Position& at, std::size_t) {
    if (few_values == FewValues::Many)
      return below(random, std::uint64_t{1} << 32);
    const std::size_t kind = static_cast<std::size_t>(at[0] / 8 + at[1] / 8 + 32) % 6;
    return few_values == FewValues::OtherFew && kind % 2 == 0
               ? bitsOf(-3.5f * static_cast<float>(1 + kind))
               : bitsOf(first[kind + below(random, 8) / 7]);
  });
  constexpr std::uint64_t specials[] = {0x7ff8000000000000,
                                        0xfff0000000000123,
                                        0x7ff0000000000000,
                                        0xfff0000000000000,
                                        0x8000000000000000,
                                        0,
                                        0x7fefffffffffffff,
                                        1};
  std::size_t at_special = 0;
  addField({"time", FieldType::Float64}, frame, [&](const Position& at, std::size_t i) {
    if (below(random, 12) == 0)
      return specials[at_special++ % 8];
    return bitsOf(1.0e9 + 0.125 * static_cast<double>(time) +
                  static_cast<double>(at[0] * 3 + static_cast<std::int64_t>(i)) / 1024);
  });
  constexpr std::uint64_t stepped_specials[] = {
      0x7fc00000, 0xffc00001, 0x7f800000, 0xff800000, 0x7f7fffff, 0x80000000};
  addField({"height", FieldType::Float32, 1, 0.0625},
           frame,
           [&](const Position& at, std::size_t) {
             if (below(random, 12) == 0)
               return stepped_specials[at_special++ % 6];
             return bitsOf(static_cast<float>(at[2]) * 0.4f);
           });
  addField({"normal", FieldType::Float32, 3, 0.0078125},
           frame,
           [&](const Position& at, std::size_t i) {
             const std::size_t axis = i % 3;
             const float noise = static_cast<float>(below(random, 4)) / 128;
             return below(random, 40) == 0
                        ? stepped_specials[at_special++ % 6]
                        : bitsOf(static_cast<float>(at[axis]) / 64 + noise);
           });
}

/** \brief Fields of all types of integers, and one whose bits are random.
 * \param[in] has_many whether the field of type i32 has many values
 */
inline void
addOtherFields(std::mt19937_64& random, bool has_many, VoxelFrame& frame)
{
  using Position = std::array<std::int64_t, 3>;
  frame.fields.clear();
  addField({"i8", FieldType::Int8}, frame, [&](const Position& at, std::size_t) {
    return static_cast<std::uint64_t>(at[1] / 16 -
                                      static_cast<std::int64_t>(below(random, 2)));
  });
  addField({"u8", FieldType::UInt8}, frame, [&](const Position&, std::size_t) {
    return below(random, 256);
  });
  addField({"i16", FieldType::Int16, 2}, frame, [&](const Position& at, std::size_t i) {
    return static_cast<std::uint64_t>(i == 0 ? at[0] * 100 : -at[2]);
  });
  addField({std::string(64, 'n'), FieldType::Int32},
           frame,
           [&](const Position& at, std::size_t) {
             return has_many ? random()
                             : static_cast<std::uint64_t>((at[0] % 5 - 2) * 400000009);
           });
  addField(
      {"u32", FieldType::UInt32, 1, 5.0}, frame, [&](const Position& at, std::size_t) {
        return static_cast<std::uint64_t>(at[0] * at[1] * 3);
      });
  addField({"f64", FieldType::Float64}, frame, [&](const Position&, std::size_t) {
    const std::uint64_t bits = random();
    return bits >> below(random, 64);
  });
}

/** \brief Points of a lidar in a room, fields of voxels, and fields beside colours and
 * within coarse voxels. */
inline GoldenStream
goldenFields(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 7, {}};
  std::mt19937_64 random(67);
  RoomStream::Settings settings;
  settings.depth = 6;
  settings.width = 12;
  settings.noise = 12;
  RoomStream room(settings);
  for (std::uint64_t i = 0; i < 10; ++i) {
    VoxelFrame frame = room.next();
    if (i == 5 || i == 7) // nothing is seen, on a P- and an I-frame
      clearVoxels(frame);
    addFewPointCounts(random, frame);
    frame.viewpoint = {7, 5, i < 7 ? 9 : -30};
    const FewValues few_values = i == 3   ? FewValues::Many
                                 : i == 2 ? FewValues::OtherFew
                                          : FewValues::Few;
    addLidarFields(random, i, few_values, frame);
    stream.frames.push_back({frame, std::nullopt});
  }
  // Other fields make I-frames of the first ones.
  for (std::uint64_t i = 0; i < 3; ++i) {
    VoxelFrame frame = room.next();
    frame.viewpoint = {-200, 33, -farthest_viewpoint};
    addColours(random, 5, frame);
    removeIntensities(frame);
    addOtherFields(random, i == 1, frame);
    stream.frames.push_back({frame, std::nullopt});
  }
  for (const bool has_points : {false, true})
    for (int i = 0; i < 2; ++i) {
      VoxelFrame frame = fineFrame(random, 8);
      frame.viewpoint = {-farthest_viewpoint, 900, 700};
      if (has_points) {
        frame.viewpoint = {1 << 16, farthest_viewpoint, -1};
        addFewPointCounts(random, frame);
      }
      addField({"ring", FieldType::UInt16},
               frame,
               [](const std::array<std::int64_t, 3>& at, std::size_t) {
                 return ringAt(at);
               });
      addField({"label", FieldType::UInt32},
               frame,
               [&](const std::array<std::int64_t, 3>&, std::size_t) {
                 return 1000 * below(random, 9);
               });
      stream.frames.push_back({frame, std::nullopt});
    }
  return stream;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test

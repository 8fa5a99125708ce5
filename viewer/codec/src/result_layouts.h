// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Layouts of the results in the module's memory, which instance.ts and others
 * read by the offsets of their members.
 */
#pragma once

#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/status.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext {
namespace viewer {

using Address = std::uint32_t;

/** \brief Where a result's array begins; 0: there is none. */
template <typename T>
Address
addressOf(const T* pointer)
{
  return static_cast<Address>(reinterpret_cast<std::uintptr_t>(pointer));
}

/** \brief Bytes, or characters in UTF-8. */
struct Span {
  Address begin = 0;
  std::uint32_t size = 0;
};

inline Span
spanOf(const std::string& text)
{
  return {addressOf(text.data()), static_cast<std::uint32_t>(text.size())};
}

/** \brief An enumerator, as CompressionCode or OutlierRemovalCode, and a message. */
struct Outcome {
  std::uint32_t code = 0;
  Span message;
};

struct Scale {
  double min = 0.0;  ///< intensity of the lowest symbol
  double max = 0.0;  ///< intensity of the highest symbol
  double step = 0.0; ///< intensity from one number to the next
  std::uint32_t bits = 0;
  std::uint32_t companded_range = 0;
};

struct Grid {
  double resolution = 0.0; ///< metres
  double origin[3] = {};   ///< metres
  std::int32_t first_index[3] = {};
  std::uint32_t depth = 0;
};

struct Stamp {
  std::uint64_t stamp = 0;
  std::uint32_t has_stamp = 0;
  Span frame_id;
};

struct DecodedFrame {
  Grid grid;
  Scale scale;
  Stamp stamp;
  Outcome outcome;
  std::uint32_t voxels = 0;
  std::uint32_t frame_number = 0;
  std::uint32_t is_i_frame = 0;
  std::uint32_t bytes = 0;
  std::uint32_t skipped_bytes = 0;
  std::uint32_t bytes_read = 0; ///< after which the next call may continue
  Address positions = 0;        ///< float[3 * voxels]
  Address intensities = 0;      ///< float[voxels]
  Address colours = 0;          ///< std::uint8_t[3 * voxels]
  Address point_counts = 0;     ///< std::uint32_t[voxels]
  Address keys = 0;             ///< std::uint64_t[voxels]
  Address symbols = 0;          ///< std::uint16_t[voxels]
  std::uint32_t fields = 0;
  Address field_descriptions = 0; ///< DescribedField[fields]
};

struct DescribedField {
  Span name;
  std::uint32_t type = 0;  ///< FieldType
  std::uint32_t count = 0; ///< values of a point
};

struct FieldValues {
  std::uint32_t voxels = 0;
  Address values = 0; ///< double[voxels]; 0: there is no such field
};

struct DescribedFrame {
  Grid grid;
  Scale scale;
  Stamp stamp;
  std::int64_t stamp_difference = 0;
  Outcome outcome;
  std::uint32_t has_stamp_difference = 0;
  std::uint32_t is_published = 0;
  std::uint32_t effort = 0;
  std::uint32_t frame_number = 0;
  std::uint32_t is_i_frame = 0;
  std::uint32_t voxels = 0;
  std::uint32_t points = 0;
  std::uint32_t colour_bits = 0;
  std::uint32_t has_point_counts = 0;
  std::uint32_t has_frame_id = 0;
  std::uint32_t has_points = 0; ///< in order
};

struct MeasuredFrame {
  Outcome outcome;
  std::uint32_t bytes = 0;
};

struct Judgement {
  Outcome outcome;
  std::uint32_t voxels = 0;
  Address is_noise = 0; ///< std::uint8_t[voxels]
};

// These numbers are in the TypeScript sources.
static_assert(sizeof(Grid) == 48 && sizeof(Scale) == 32 && sizeof(Stamp) == 24);
static_assert(offsetof(DecodedFrame, outcome) == 104 &&
              offsetof(DecodedFrame, voxels) == 116 &&
              offsetof(DecodedFrame, symbols) == 160 &&
              offsetof(DecodedFrame, field_descriptions) == 168);
static_assert(sizeof(DescribedField) == 16 && offsetof(FieldValues, values) == 4);
static_assert(offsetof(DescribedFrame, outcome) == 112 &&
              offsetof(DescribedFrame, has_points) == 164);
static_assert(offsetof(MeasuredFrame, bytes) == 12);
static_assert(offsetof(Judgement, is_noise) == 16);
static_assert(static_cast<int>(io::CompressionCode::OutOfMemory) == 13);
static_assert(static_cast<int>(OutlierRemovalCode::DifferentCloud) == 4);

} // namespace viewer
} // namespace pcl_ext

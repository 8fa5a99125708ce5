// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/scan_coder.h"

#include "codec/scan/plane.h"
#include "codec/scan/plane_bytes.h"
#include "codec/scan/sequence.h"
#include "platforms/run_at_once.h"

#include <algorithm>
#include <cstdlib>
#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

namespace {

/** \brief Numbers of a difference of 0 between colour channels, between the angles of
 * columns, and of points on their rays. */
constexpr std::uint32_t zero_difference = std::uint32_t{1} << 8;
constexpr std::uint32_t zero_off = number_end / 2;

/** \brief Whether points are near enough to the places of their depths. */
bool
areNear(const std::vector<PointBesideRay>& points)
{
  return std::all_of(points.begin(), points.end(), [](const PointBesideRay& point) {
    return std::all_of(point.steps.begin(), point.steps.end(), [](std::int32_t steps) {
      return std::abs(steps) < most_steps;
    });
  });
}

bool
areAtOrigin(const std::vector<std::uint32_t>& depths)
{
  return std::all_of(depths.begin(), depths.end(), [](std::uint32_t depth) {
    return depth == 0 || depth == at_sensor;
  });
}

/** \brief Codes the values of a plane that are there. */
template <class PlanesT>
bool
codePlane(PlanesT& planes, const Plane& plane, std::uint32_t first)
{
  return planes.codePlane([&](auto& coding) {
    return PlanePass<std::decay_t<decltype(coding)>>(plane, first, nullptr)
        .codeValues(coding);
  });
}

} // namespace

std::size_t
ScanCoder::encode(bool is_i_frame,
                  const ScanFrame& frame,
                  std::vector<std::uint8_t>& bytes,
                  unsigned int threads)
{
  changes_fields_ = !frame.pixels.empty() && !frame.fields.empty();
  forgets_fields_ = is_i_frame && !changes_fields_;
  std::size_t size_of_places = 0;
  if (changes_fields_ && threads > 1 && frame.pixels.size() >= least_points_per_part) {
    field_bytes_.clear();
    runAtOnce(2, [&](std::size_t i) {
      if (i == 0)
        size_of_places = encodePlanes(is_i_frame, frame, bytes);
      else
        fields_.encode(is_i_frame, frame, field_bytes_);
    });
    bytes.insert(bytes.end(), field_bytes_.begin(), field_bytes_.end());
  }
  else {
    size_of_places = encodePlanes(is_i_frame, frame, bytes);
    if (changes_fields_)
      fields_.encode(is_i_frame, frame, bytes);
  }
  changes_fields_ = false; // learnt
  learn();
  return size_of_places;
}

/** \brief Appends all but fields; returns the size of what says where points are. */
std::size_t
ScanCoder::encodePlanes(bool is_i_frame,
                        const ScanFrame& frame,
                        std::vector<std::uint8_t>& bytes)
{
  depths_.clear(); // without points the next frame has nothing before it
  if (frame.pixels.empty())
    return 0;
  depths_.resize(frame.pixelCount(), no_number);
  for (std::size_t point = 0; point < frame.pixels.size(); ++point)
    depths_[frame.pixels[point]] = frame.depths[point];
  const std::size_t begin = bytes.size();
  PlaneWriter planes(work_, plane_bytes_, bytes);
  codePlaces(planes, is_i_frame, frame.pixels.size(), frame);
  const std::size_t size_of_places = bytes.size() - begin;
  codeAttributes(planes, frame);
  return size_of_places;
}

bool
ScanCoder::decode(bool is_i_frame,
                  const std::uint8_t* begin,
                  const std::uint8_t* end,
                  std::uint64_t point_count,
                  ScanFrame& frame)
{
  frame.clearPoints();
  changes_fields_ = point_count > 0 && !frame.fields.empty();
  forgets_fields_ = is_i_frame && !changes_fields_;
  depths_.clear();
  if (point_count == 0) // the next frame has nothing before it
    return begin == end;
  PlaneReader planes(work_, begin, end);
  if (!codePlaces(planes, is_i_frame, point_count, frame) ||
      frame.pixels.size() != point_count || !codeAttributes(planes, frame))
    return false;
  return changes_fields_ ? fields_.decode(is_i_frame, planes.next(), end, frame)
                         : planes.isAtEnd();
}

void
ScanCoder::learn() noexcept
{
  past_.swap(depths_);
  past_width_ = width_;
  past_columns_.swap(columns_);
  if (changes_fields_)
    fields_.learn();
  if (forgets_fields_)
    fields_.reset();
  changes_fields_ = false;
  forgets_fields_ = false;
}

void
ScanCoder::releaseMemory()
{
  fields_.releaseMemory();
  depths_ = std::vector<std::uint32_t>();
  aligned_past_ = std::vector<std::uint32_t>();
  values_ = std::vector<std::uint32_t>();
  steps_ = std::vector<std::array<std::int32_t, 3>>();
  work_ = SymbolWorkspace();
  plane_bytes_ = std::vector<std::uint8_t>();
  field_bytes_ = std::vector<std::uint8_t>();
}

/** \brief Codes where points are. The encoder has set depths_, the decoder does. */
template <class PlanesT, class FrameT>
bool
ScanCoder::codePlaces(PlanesT& planes,
                      bool is_i_frame,
                      std::uint64_t point_count,
                      FrameT& frame)
{
  if (frame.rays.shape == RayShape::Free)
    return codeFreePlaces(planes, point_count, frame);
  // Where many points are beside their rays, all are told how far, else each of these is.
  static const std::vector<PointBesideRay> none;
  bool are_many = 6 * frame.beside.size() > frame.pixels.size();
  if (!planes.codeFlag(are_many))
    return false;
  if (frame.rays.shape == RayShape::Spinning && !codeColumns(planes, frame))
    return false;
  width_ = frame.width;
  columns_ = frame.rays.columns;
  const std::uint32_t* const past = is_i_frame ? nullptr : alignPast(frame);
  if (!planes.codePlane([&](auto& coding) {
        PlanePass<std::decay_t<decltype(coding)>> pass(
            {frame.width, frame.height, depths_}, 0, past);
        if constexpr (!PlanesT::is_decoder)
          return pass.codeDepths(coding, are_many ? none : frame.beside);
        else
          return pass.codeDepths(coding, frame.beside) &&
                 (!are_many || frame.beside.empty());
      }))
    return false;
  if constexpr (PlanesT::is_decoder)
    if (!takePoints(frame))
      return false;
  if (are_many && !codeSteps(planes, frame))
    return false;
  if constexpr (PlanesT::is_decoder)
    if (!areNear(frame.beside))
      return false;
  return frame.rays.shape != RayShape::Spinning || codeTurns(planes, frame);
}

/** \brief Codes where points without rays are. */
template <class PlanesT, class FrameT>
bool
ScanCoder::codeFreePlaces(PlanesT& planes, std::uint64_t point_count, FrameT& frame)
{
  width_ = frame.width;
  columns_.clear();
  if (!codeFreePixels(planes, point_count, frame))
    return false;
  steps_.clear();
  std::vector<std::uint32_t> pixels; // of points that are not at the sensor
  pixels.reserve(frame.pixels.size());
  for (std::size_t point = 0; point < frame.pixels.size(); ++point)
    if (frame.depths[point] == 0)
      pixels.push_back(frame.pixels[point]);
  if constexpr (!PlanesT::is_decoder)
    setSteps(pixels, frame.beside);
  else
    steps_.resize(pixels.size());
  if (!planes.codePlane(
          [&](auto& coding) {
            return SequencePass<std::decay_t<decltype(coding)>>(
                       frame.width, pixels, steps_)
                .code(coding);
          },
          sequence_contexts))
    return false;
  if constexpr (PlanesT::is_decoder)
    for (std::size_t point = 0; point < pixels.size(); ++point)
      if ((steps_[point][0] | steps_[point][1] | steps_[point][2]) != 0)
        frame.beside.push_back({pixels[point], steps_[point]});
  return true;
}

/** \brief Codes which pixels have points without rays, and which of these are at the
 * sensor; of a sequence this is known. */
template <class PlanesT, class FrameT>
bool
ScanCoder::codeFreePixels(PlanesT& planes, std::uint64_t point_count, FrameT& frame)
{
  if (!frame.isSequence()) {
    static const std::vector<PointBesideRay> none;
    return planes.codePlane([&](auto& coding) {
      PlanePass<std::decay_t<decltype(coding)>> pass(
          {frame.width, frame.height, depths_}, 0, nullptr);
      if constexpr (!PlanesT::is_decoder)
        return pass.codeDepths(coding, none);
      else
        return pass.codeDepths(coding, frame.beside) && frame.beside.empty() &&
               takePoints(frame) && areAtOrigin(frame.depths);
    });
  }
  if constexpr (PlanesT::is_decoder) {
    // The last row has a point, and a lone row is full, so that points bound all sizes.
    const std::uint64_t pixels = frame.pixelCount();
    if (point_count > pixels || point_count + frame.width <= pixels ||
        (frame.height == 1 && point_count != pixels))
      return false;
    depths_.assign(frame.pixelCount(), no_number);
    std::fill_n(depths_.begin(), point_count, 0);
    return takePoints(frame);
  }
  return true;
}

/** \brief The depths of the frame before, in the columns whose angles are nearest to
 * those of the frame, as both turn in the same direction; null: there are none. */
const std::uint32_t*
ScanCoder::alignPast(const ScanLayout& layout)
{
  if (past_.empty() || past_.size() != std::size_t{past_width_} * layout.height)
    return nullptr;
  if (past_columns_ == columns_)
    return past_width_ == width_ ? past_.data() : nullptr;
  if (past_columns_.empty())
    return nullptr;
  const auto distance = [&](std::size_t past, std::size_t column) {
    return std::abs(std::int64_t{past_columns_[past]} - columns_[column]);
  };
  aligned_past_.assign(std::size_t{width_} * layout.height, no_number);
  std::size_t past = 0;
  for (std::size_t column = 0; column < columns_.size(); ++column) {
    while (past + 1 < past_columns_.size() &&
           distance(past + 1, column) <= distance(past, column))
      ++past;
    for (std::uint32_t row = 0; row < layout.height; ++row) {
      const std::uint32_t shift = layout.shiftOf(row);
      aligned_past_[std::size_t{row} * width_ + column + shift] =
          past_[std::size_t{row} * past_width_ + past + shift];
    }
  }
  return aligned_past_.data();
}

/** \brief Codes intensities and colours. */
template <class PlanesT, class FrameT>
bool
ScanCoder::codeAttributes(PlanesT& planes, FrameT& frame)
{
  if constexpr (PlanesT::is_decoder)
    frame.intensities.resize(frame.intensity_scale.bits > 0 ? frame.pixels.size() : 0);
  const std::uint32_t highest = frame.intensity_scale.maxSymbol();
  return (frame.intensity_scale.bits == 0 ||
          codeValues(planes,
                     frame,
                     0,
                     [&](std::size_t point, auto& number) {
                       auto& intensity = frame.intensities[point];
                       if constexpr (PlanesT::is_decoder)
                         intensity = static_cast<std::uint16_t>(number);
                       else
                         number = intensity;
                       return number <= highest;
                     })) &&
         (frame.colour_bits == 0 || codeColours(planes, frame));
}

/** \brief Takes the points of a frame from its decoded depths.
 * \return false if some are too far away, or in pixels without a ray
 */
bool
ScanCoder::takePoints(ScanFrame& frame) const
{
  const std::uint32_t columns = frame.rayColumns();
  std::uint32_t pixel = 0;
  for (std::uint32_t row = 0; row < frame.height; ++row) {
    const std::uint32_t first = row * frame.width + frame.shiftOf(row);
    for (const std::uint32_t end = pixel + frame.width; pixel < end; ++pixel) {
      const std::uint32_t depth = depths_[pixel];
      if (depth == no_number)
        continue;
      if ((depth >= depth_end && depth != at_sensor) || pixel - first >= columns)
        return false;
      frame.pixels.push_back(pixel);
      frame.depths.push_back(depth);
    }
  }
  return true;
}

/** \brief Codes the angles of the columns, each by its difference from the one before. */
template <class PlanesT, class FrameT>
bool
ScanCoder::codeColumns(PlanesT& planes, FrameT& frame)
{
  auto& angles = frame.rays.columns;
  if constexpr (PlanesT::is_decoder)
    angles.resize(frame.rayColumns());
  values_.assign(frame.rayColumns(), 0);
  std::uint32_t last = 0;
  if constexpr (!PlanesT::is_decoder)
    for (std::size_t column = 0; column < angles.size(); ++column) {
      const auto angle = static_cast<std::uint32_t>(angles[column]);
      values_[column] = (angle - last + zero_off) % number_end;
      last = angle;
    }
  if (!codePlane(planes, {frame.rayColumns(), 1, values_}, zero_off))
    return false;
  if constexpr (PlanesT::is_decoder)
    for (std::size_t column = 0; column < angles.size(); ++column) {
      last += values_[column] - zero_off;
      angles[column] = static_cast<std::int32_t>(last);
    }
  return true;
}

/** \brief Codes how far the rays of points are turned from those of their pixels. */
template <class PlanesT, class FrameT>
bool
ScanCoder::codeTurns(PlanesT& planes, FrameT& frame)
{
  bool has_turns = !frame.turns.empty();
  if (!planes.codeFlag(has_turns))
    return false;
  if constexpr (PlanesT::is_decoder)
    frame.turns.resize(has_turns ? frame.pixels.size() : 0);
  return !has_turns ||
         codeValues(planes, frame, zero_off, [&](std::size_t point, auto& number) {
           if constexpr (PlanesT::is_decoder)
             frame.turns[point] = static_cast<std::int32_t>(number - zero_off);
           else
             number = static_cast<std::uint32_t>(frame.turns[point]) + zero_off;
           return true;
         });
}

/** \brief Sets how far points are from the places of their depths. */
void
ScanCoder::setSteps(const std::vector<std::uint32_t>& pixels,
                    const std::vector<PointBesideRay>& beside)
{
  steps_.assign(pixels.size(), {});
  std::size_t point = 0;
  for (const PointBesideRay& next : beside) {
    while (pixels[point] < next.pixel)
      ++point;
    steps_[point] = next.steps;
  }
}

/** \brief Codes how far all points are from the places of their depths, axis by axis. */
template <class PlanesT, class FrameT>
bool
ScanCoder::codeSteps(PlanesT& planes, FrameT& frame)
{
  if constexpr (PlanesT::is_decoder)
    steps_.assign(frame.pixels.size(), {});
  else
    setSteps(frame.pixels, frame.beside);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!codeValues(planes, frame, zero_off, [&](std::size_t point, auto& number) {
          if constexpr (PlanesT::is_decoder)
            steps_[point][axis] = static_cast<std::int32_t>(number - zero_off);
          else
            number = static_cast<std::uint32_t>(steps_[point][axis]) + zero_off;
          return true;
        }))
      return false;
  if constexpr (PlanesT::is_decoder)
    for (std::size_t point = 0; point < steps_.size(); ++point)
      if (steps_[point] != std::array<std::int32_t, 3>{}) {
        // Points at the sensor have no steps of their own, either.
        if (frame.depths[point] == at_sensor)
          return false;
        frame.beside.push_back({frame.pixels[point], steps_[point]});
      }
  return true;
}

/** \brief Codes green, and red and blue by how much they are above it. */
template <class PlanesT, class FrameT>
bool
ScanCoder::codeColours(PlanesT& planes, FrameT& frame)
{
  if constexpr (PlanesT::is_decoder)
    frame.colours.resize(frame.pixels.size());
  const std::uint32_t end = 1u << frame.colour_bits;
  const auto code_channel = [&](auto channel) {
    const bool is_green = channel == &VoxelColour::g;
    return codeValues(planes,
                      frame,
                      is_green ? 0 : zero_difference,
                      [&, is_green, channel](std::size_t point, auto& number) {
                        auto& colour = frame.colours[point];
                        const std::uint32_t base =
                            is_green ? 0 : zero_difference - colour.g;
                        if constexpr (PlanesT::is_decoder) {
                          if (number - base >= end)
                            return false;
                          colour.*channel = static_cast<std::uint8_t>(number - base);
                        }
                        else {
                          number = colour.*channel + base;
                        }
                        return true;
                      });
  };
  return code_channel(&VoxelColour::g) && code_channel(&VoxelColour::r) &&
         code_channel(&VoxelColour::b);
}

/** \brief Codes a number of each point.
 * \param[in] value called as value(point, number): sets the number for the encoder, takes
 * it from the decoder; returns whether it is one
 */
template <class PlanesT, class ValueT>
bool
ScanCoder::codeValues(PlanesT& planes,
                      const ScanFrame& frame,
                      std::uint32_t first,
                      const ValueT& value)
{
  values_ = depths_;
  std::size_t point = 0;
  for (std::uint32_t& number : values_)
    if (number != no_number) {
      number = 0;
      if (!PlanesT::is_decoder)
        value(point++, number);
    }
  if (!codePlane(planes, {frame.width, frame.height, values_}, first))
    return false;
  if constexpr (PlanesT::is_decoder)
    for (std::uint32_t& number : values_)
      if (number != no_number && !value(point++, number))
        return false;
  return true;
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "codec/scan/scan_frame.h"
#include "support/voxel_frames.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

struct GoldenFrame {
  VoxelFrame frame; ///< of a scan its points
  std::optional<FrameStamp> stamp;
  std::optional<Effort> begins_sender = std::nullopt; ///< a new encoder begins with it
  std::optional<scan::ScanFrame> scan = std::nullopt; ///< coded in place of voxels
};

struct Sending {
  enum class Damage { None, InvertedBit, CutOff };

  std::size_t frame; ///< index
  bool is_decoded = true;
  Damage damage = Damage::None;
  std::string before = {}; ///< bytes before it that are no frame
};

struct GoldenStream {
  std::string name;
  Effort effort;
  unsigned int i_frame_rate;
  std::vector<GoldenFrame> frames;
  std::vector<Sending> sendings = {}; ///< none: each frame once
};

/** \brief FNV-1a with 64 bits over numbers of 64 bits. */
class Checksum {
public:
  std::uint64_t
  value() const
  {
    return value_;
  }

protected:
  void
  add(std::uint64_t number)
  {
    for (int byte = 0; byte < 8; ++byte, number >>= 8) {
      value_ ^= number & 0xff;
      value_ *= 0x100000001b3;
    }
  }

private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

/** \brief The checksum of all that a voxel frame says of its voxels, but fields. */
class VoxelChecksum : public Checksum {
public:
  explicit VoxelChecksum(const VoxelFrame& frame)
  {
    for (const std::int32_t index : frame.grid.first_index)
      add(static_cast<std::uint32_t>(index));
    add(frame.grid.depth);
    add(frame.intensity_scale.bits);
    add(frame.intensity_scale.companded_range);
    add(frame.keys.size());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      add(frame.keys[i]);
      if (frame.hasIntensities())
        add(frame.intensities[i]);
      if (frame.intensity_scale.companded_range != 0)
        add(compandedMiddle(frame.intensity_scale.bits,
                            frame.intensity_scale.companded_range,
                            frame.intensities[i]));
      if (frame.colour_bits > 0)
        for (const std::uint8_t channel :
             {frame.colours[i].r, frame.colours[i].g, frame.colours[i].b})
          add(channel);
      if (frame.has_point_counts)
        add(frame.point_counts[i]);
    }
  }
};

/** \brief The same of the numbers of all fields. */
class FieldChecksum : public Checksum {
public:
  explicit FieldChecksum(const VoxelFrame& frame)
  {
    for (const FrameField& field : frame.fields)
      for (const std::uint64_t number : field.numbers)
        add(number);
  }
};

/** \brief The same of points: width and height of their cloud, and of each point its
 * index, the bits of its position as floats, its intensity and its colour. Not as
 * doubles, whose last bits differ where processors have more of them than a double. */
class PointChecksum : public Checksum {
public:
  explicit PointChecksum(const VoxelFrame& frame)
  {
    const FramePoints& points = frame.points;
    add(points.width);
    add(points.height);
    for (std::size_t i = 0; i < points.indices.size(); ++i) {
      add(points.indices[i]);
      for (const double position : points.positions[i]) {
        const auto coordinate = static_cast<float>(position);
        std::uint32_t bits = 0;
        std::memcpy(&bits, &coordinate, sizeof(bits));
        add(bits);
      }
      if (frame.hasIntensities())
        add(points.intensities[i]);
      if (frame.colour_bits > 0)
        for (const std::uint8_t channel :
             {points.colours[i].r, points.colours[i].g, points.colours[i].b})
          add(channel);
    }
  }
};

/** \brief The same of the layout of messages. */
class LayoutChecksum : public Checksum {
public:
  explicit LayoutChecksum(const MessageLayout& layout)
  {
    for (const PlacedField& field : layout.fields) {
      for (const char letter : field.name)
        add(static_cast<std::uint8_t>(letter));
      add(static_cast<std::uint8_t>(field.type));
      add(field.count);
      add(field.offset);
    }
    add(layout.point_step);
    add(layout.row_padding);
  }
};

/** \brief What checksums.txt has of a frame, except for the name of its stream and
 * whether it is an I-frame: number of voxels or points, checksum, stamp and frame_id or
 * -, and with fields the checksum of these, and with points and a layout those of them.
 * */
inline std::string
lineOf(const GoldenFrame& frame)
{
  std::ostringstream line;
  const VoxelFrame& voxels = frame.frame;
  line << (voxels.points.areThere() ? voxels.pointCount() : voxels.size()) << ' '
       << std::hex << std::setw(16) << std::setfill('0')
       << VoxelChecksum(frame.frame).value() << std::dec << ' ';
  if (frame.stamp)
    line << frame.stamp->stamp << " '" << frame.stamp->frame_id << '\'';
  else
    line << '-';
  if (frame.frame.fieldValueCount() > 0)
    line << " fields " << std::hex << std::setw(16) << std::setfill('0')
         << FieldChecksum(frame.frame).value();
  if (frame.frame.points.areThere())
    line << " points " << std::hex << std::setw(16) << std::setfill('0')
         << PointChecksum(frame.frame).value();
  if (frame.frame.layout)
    line << " layout " << std::hex << std::setw(16) << std::setfill('0')
         << LayoutChecksum(*frame.frame.layout).value();
  return line.str();
}

struct SentStream {
  Bytes bytes;
  std::vector<std::size_t> decoded; ///< indices of frames, as they are decoded
  std::vector<bool> are_i_frames;   ///< of all frames
};

inline SentStream
sent(const GoldenStream& stream)
{
  SentStream result;
  std::optional<FrameEncoder> encoder;
  encoder.emplace(StreamFormat::Version1, stream.i_frame_rate, stream.effort);
  std::vector<Bytes> frames;
  std::vector<Sending> sendings = stream.sendings;
  for (const GoldenFrame& frame : stream.frames) {
    if (frame.begins_sender)
      encoder.emplace(
          StreamFormat::Version1, stream.i_frame_rate, *frame.begins_sender);
    if (stream.sendings.empty())
      sendings.push_back({frames.size()});
    frames.push_back(frame.scan ? encoded(*encoder, *frame.scan, frame.stamp)
                                : encoded(*encoder, frame.frame, frame.stamp));
    result.are_i_frames.push_back(encoder->statistics().is_i_frame);
  }
  for (const Sending& sending : sendings) {
    append({sending.before.begin(), sending.before.end()}, result.bytes);
    Bytes bytes = frames[sending.frame];
    if (sending.damage == Sending::Damage::InvertedBit)
      bytes = flipped(bytes, 8 * bytes.size() - 5);
    if (sending.damage == Sending::Damage::CutOff)
      bytes.resize(bytes.size() - 3);
    append(bytes, result.bytes);
    if (sending.is_decoded)
      result.decoded.push_back(sending.frame);
  }
  return result;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test

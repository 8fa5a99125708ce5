// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * zstd over the preprocessed points, 16 bytes each, and over all points as whole
 * numbers, 12 bytes each.
 */
#include "coders/stream_coder.h"
#include "coders/whole_number_coder.h"

#include <pcl/common/io.h>

#include <zstd.h>

#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

std::string
zstdName(int level)
{
  return std::string("zstd ") + ZSTD_versionString() + " -" + std::to_string(level);
}

std::size_t
demand(std::size_t result)
{
  if (ZSTD_isError(result) != 0)
    throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(result));
  return result;
}

/** \brief Compresses and decompresses arrays of a type. */
template <typename ItemT>
class ZstdArrays {
public:
  explicit ZstdArrays(int level)
  : level_(level)
  , compressor_(ZSTD_createCCtx(), ZSTD_freeCCtx)
  , decompressor_(ZSTD_createDCtx(), ZSTD_freeDCtx)
  {}

  void
  compress(const std::vector<ItemT>& items)
  {
    const std::size_t raw_bytes = items.size() * sizeof(ItemT);
    bytes_.resize(ZSTD_compressBound(raw_bytes));
    size_ = demand(ZSTD_compressCCtx(compressor_.get(),
                                     bytes_.data(),
                                     bytes_.size(),
                                     items.data(),
                                     raw_bytes,
                                     level_));
  }

  void
  decompress(std::vector<ItemT>& items)
  {
    const auto raw_bytes = ZSTD_getFrameContentSize(bytes_.data(), size_);
    items.resize(raw_bytes / sizeof(ItemT));
    demand(ZSTD_decompressDCtx(
        decompressor_.get(), items.data(), raw_bytes, bytes_.data(), size_));
  }

  std::size_t
  size() const
  {
    return size_;
  }

private:
  int level_;
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> compressor_;
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> decompressor_;
  std::vector<char> bytes_;
  std::size_t size_ = 0;
};

class ZstdCoder : public StreamCoder {
public:
  ZstdCoder() : StreamCoder(zstdName(level), Content::PointsWithIntensity) {}

  void
  encode(const InputFrame& frame) override
  {
    packed_.clear();
    packed_.reserve(frame.points->size());
    for (const pcl::PointXYZI& point : *frame.points)
      packed_.push_back({point.x, point.y, point.z, point.intensity});
    arrays_.compress(packed_);
    frame_bytes_ = arrays_.size();
  }

  void
  decode() override
  {
    arrays_.decompress(unpacked_);
    decoded_->resize(unpacked_.size());
    for (std::size_t i = 0; i < unpacked_.size(); ++i) {
      pcl::PointXYZI& point = (*decoded_)[i];
      point.x = unpacked_[i][0];
      point.y = unpacked_[i][1];
      point.z = unpacked_[i][2];
      point.intensity = unpacked_[i][3];
    }
  }

  void
  check(const InputFrame& frame) override
  {
    const IntensityCloud& points = *frame.points;
    bool is_same = points.size() == decoded_->size();
    for (std::size_t i = 0; is_same && i < points.size(); ++i)
      is_same = points[i].getVector3fMap() == (*decoded_)[i].getVector3fMap() &&
                points[i].intensity == (*decoded_)[i].intensity;
    if (!is_same)
      throw std::runtime_error("zstd decoded other points than were encoded");
    pcl::copyPointCloud(*decoded_, *positions_);
  }

private:
  using PackedPoint = std::array<float, 4>;

  /** \brief zstd's own default. */
  static constexpr int level = 3;

  ZstdArrays<PackedPoint> arrays_{level};
  std::vector<PackedPoint> packed_;
  std::vector<PackedPoint> unpacked_;
  IntensityCloud::Ptr decoded_{new IntensityCloud};
};

/** \brief All points, as whole numbers. */
class ZstdPointsCoder : public WholeNumberCoder {
public:
  explicit ZstdPointsCoder(const Workload& workload)
  : WholeNumberCoder(zstdName(level), workload.resolution)
  {}

protected:
  void
  encodePositions(const WholePositions& positions) override
  {
    arrays_.compress(positions);
    frame_bytes_ = arrays_.size();
  }

  void
  decodePositions(WholePositions& positions) override
  {
    arrays_.decompress(positions);
  }

private:
  /** \brief The largest without options that take more memory to decompress. */
  static constexpr int level = 19;

  ZstdArrays<WholePositions::value_type> arrays_{level};
};

} // namespace

void
addZstdCoder(StreamCoders& coders)
{
  coders.push_back(std::make_unique<ZstdCoder>());
}

void
addZstdPointsCoder(const Workload& workload, StreamCoders& coders)
{
  coders.push_back(std::make_unique<ZstdPointsCoder>(workload));
}

} // namespace measuring
} // namespace pcl_ext

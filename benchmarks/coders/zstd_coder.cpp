/** \file
 * zstd over the preprocessed points, 16 bytes each.
 */
#include "coders/stream_coder.h"

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

class ZstdCoder : public StreamCoder {
public:
  ZstdCoder()
  : StreamCoder(std::string("zstd ") + ZSTD_versionString() + " -" +
                    std::to_string(level),
                Content::PointsWithIntensity)
  , compressor_(ZSTD_createCCtx(), ZSTD_freeCCtx)
  , decompressor_(ZSTD_createDCtx(), ZSTD_freeDCtx)
  {}

  void
  encode(const InputFrame& frame) override
  {
    packed_.clear();
    packed_.reserve(frame.points->size());
    for (const pcl::PointXYZI& point : *frame.points)
      packed_.push_back({point.x, point.y, point.z, point.intensity});
    const std::size_t raw_bytes = packed_.size() * sizeof(PackedPoint);
    bytes_.resize(ZSTD_compressBound(raw_bytes));
    size_ = demand(ZSTD_compressCCtx(compressor_.get(),
                                     bytes_.data(),
                                     bytes_.size(),
                                     packed_.data(),
                                     raw_bytes,
                                     level));
  }

  std::size_t
  frameBytes() const override
  {
    return size_;
  }

  void
  decode() override
  {
    const auto raw_bytes = ZSTD_getFrameContentSize(bytes_.data(), size_);
    unpacked_.resize(raw_bytes / sizeof(PackedPoint));
    demand(ZSTD_decompressDCtx(
        decompressor_.get(), unpacked_.data(), raw_bytes, bytes_.data(), size_));
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

  PositionCloud::ConstPtr
  decodedPositions() const override
  {
    return positions_;
  }

private:
  using PackedPoint = std::array<float, 4>;

  /** \brief zstd's own default. */
  static constexpr int level = 3;

  static std::size_t
  demand(std::size_t result)
  {
    if (ZSTD_isError(result) != 0)
      throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(result));
    return result;
  }

  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> compressor_;
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> decompressor_;
  std::vector<PackedPoint> packed_;
  std::vector<PackedPoint> unpacked_;
  std::vector<char> bytes_;
  std::size_t size_ = 0;
  IntensityCloud::Ptr decoded_{new IntensityCloud};
  PositionCloud::Ptr positions_{new PositionCloud};
};

} // namespace

void
addZstdCoder(StreamCoders& coders)
{
  coders.push_back(std::make_unique<ZstdCoder>());
}

} // namespace measuring
} // namespace pcl_ext

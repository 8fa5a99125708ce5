// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/rans/nibble_model.h"
#include "codec/supplement/fields.h"
#include "codec/supplement/numbers.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace supplement {

/** \brief No point, in the place of a depth. */
constexpr std::uint32_t no_depth = ~std::uint32_t{0};

/** \brief A point at the sensor, likewise. */
constexpr std::uint32_t sensor_depth = no_depth - 1;

/** \brief Models of an image. */
struct ImageModels {
  static constexpr std::size_t gradient_classes = 12;
  static constexpr std::size_t error_classes = 20;
  static constexpr std::size_t margin_classes = 8;
  static constexpr std::size_t miss_classes = 4;

  std::array<rans::BitModel, 64> is_point;
  std::array<rans::BitModel, 64> is_at_sensor;
  std::array<rans::NibbleModel, gradient_classes * error_classes> depths;
  std::array<rans::BitModel, margin_classes * miss_classes> is_on_ray;
  std::array<rans::NibbleModel, 3 * miss_classes> offsets;
  WideNumberModels wide;
};

/** \brief The points of a frame by their pixels, row after row. */
struct PixelPoints {
  std::vector<std::uint32_t> depths; ///< or no_depth, sensor_depth
  std::vector<std::uint64_t> keys;   ///< Morton keys of their voxels, of points only
};

/** \brief Codes the voxels of frames whose points have the order of a sensor, for either
 * direction (doc/bitstream_supplement.md, "Image"). */
class ImageCoder {
public:
  /** \brief Codes the points of a frame.
   * \param[in,out] coding a NumberCoding
   * \param[in] is_i_frame forgets what was before
   * \param[in] point_count number of points
   * \param[in,out] frame grid, size of the image and rays are given; the decoder sets
   * voxels, numbers of points, pixels and depths
   * \return false if what was decoded is no image
   */
  template <class CodingT, class FrameT>
  bool
  code(CodingT& coding, bool is_i_frame, std::uint64_t point_count, FrameT& frame);

  /** \brief Learns the frame that was coded last. */
  void
  learn() noexcept;

  /** \brief Forgets all frames. */
  void
  reset() noexcept;

  void
  releaseMemory();

private:
  /** \brief A point to be sorted into its voxel. */
  struct Entry {
    std::uint64_t key;
    std::uint32_t pixel;
  };

  friend std::uint64_t
  keyOf(const Entry& entry)
  {
    return entry.key;
  }

  void
  spreadPoints(const VoxelFrame& frame);

  void
  collectPoints(VoxelFrame& frame);

  ImageModels models_;
  ImageModels next_models_;
  /** \brief Means of the depths of each pixel, in sixteenths, or no_depth. */
  std::vector<std::uint32_t> past_;
  std::vector<std::uint32_t> next_past_;
  // Of the current frame; members so that their memory is reused.
  PixelPoints points_;
  std::vector<std::uint64_t> spread_keys_;
  std::vector<Entry> entries_;
  std::vector<Entry> spare_;
};

extern template bool
ImageCoder::code(NumberCoding<rans::NibbleEncoder>&,
                 bool,
                 std::uint64_t,
                 const VoxelFrame&);
extern template bool
ImageCoder::code(NumberCoding<rans::NibbleDecoder>&, bool, std::uint64_t, VoxelFrame&);

} // namespace supplement
} // namespace io
} // namespace pcl_ext

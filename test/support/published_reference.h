// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The *published* stream layout, written a second time on PCL's own classes.
 *
 * Dybedal, Aalerud and Hovland, "Embedded Processing and Compression of 3D Sensor Data
 * for Large Scale Industrial Environments", Sensors 2019, 19(3), 636, compress voxels
 * with a double-buffered PCL octree and PCL's static range coder. This file does the
 * same with pcl::octree::OctreePointCloud, pcl::octree::Octree2BufBase and
 * pcl::StaticRangeCoder, so that the library's own reader and writer of that layout can
 * be checked against code that shares nothing with them.
 *
 * One frame, all numbers in the host's byte order (little-endian on every machine PCL
 * is commonly built for, and PCL's range coder writes its table the same way):
 *
 *     "<HEAD>"  u32 frame number, from 1  u8 is-I-frame
 *     I-frames: u64 leaf count  f64 resolution
 *               f64 min_x min_y min_z max_x max_y max_z     of PCL's octree, metres
 *     u64 n     n occupancy bytes, range coded; XORed with the last frame's on P-frames
 *     u64 m     m intensity bytes, range coded, in the order of serialization
 *
 * Links with support/pcl_range_coder.cpp; pcl_io need not be linked, pcl_octree and
 * pcl_common suffice.
 */
#pragma once

// PCL's implementation headers rely on their declarations standing before them.
// clang-format off
#include <pcl/compression/entropy_range_coder.h>
#include <pcl/octree/octree2buf_base.h>
#include <pcl/octree/impl/octree2buf_base.hpp>
#include <pcl/octree/octree_pointcloud.h>
#include <pcl/octree/impl/octree_pointcloud.hpp>
// clang-format on
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace published {

inline const std::string frame_mark = "<HEAD>";

/** \brief A leaf that sums the intensities of its points. */
class IntensitySumLeaf : public pcl::octree::OctreeContainerBase {
public:
  void
  reset() override
  {
    sum_ = 0.0f;
  }

  void
  add(float intensity)
  {
    sum_ += intensity;
  }

  float
  sum() const
  {
    return sum_;
  }

  /** \brief The sum as it goes on the wire: truncated to an integer, within 0..255. */
  char
  byte() const
  {
    const float clamped = std::min(255.0f, std::max(0.0f, sum_));
    return static_cast<char>(static_cast<std::uint8_t>(clamped));
  }

private:
  float sum_ = 0.0f;
};

/** \brief PCL's double-buffered octree over PointXYZI, one intensity sum per leaf. */
using IntensityOctree = pcl::octree::OctreePointCloud<
    pcl::PointXYZI,
    IntensitySumLeaf,
    pcl::octree::OctreeContainerEmpty,
    pcl::octree::Octree2BufBase<IntensitySumLeaf, pcl::octree::OctreeContainerEmpty>>;

template <typename NumberT>
inline void
writeNumber(std::ostream& stream, NumberT number)
{
  stream.write(reinterpret_cast<const char*>(&number), sizeof(number));
}

/** \brief Read a number as the bytes it has in memory.
 * \throws std::runtime_error where the stream ends too early
 */
template <typename NumberT>
inline NumberT
readNumber(std::istream& stream)
{
  NumberT number{};
  if (!stream.read(reinterpret_cast<char*>(&number), sizeof(number)))
    throw std::runtime_error("published frame: the stream ends within a frame");
  return number;
}

} // namespace published

/** \brief Writes the published layout (see the file's description). */
class PublishedReference : private published::IntensityOctree {
public:
  /** \brief A stream with its first frame still to come.
   * \param[in] resolution voxel edge, metres, > 0
   * \param[in] crop_min, crop_max corners of the crop box, metres. PCL centres its
   * cube on this box, so its grid is in general *not* anchored at the world's origin.
   * Both zero, as the authors' program has them when it shall not crop: two voxels an
   * axis, which PCL enlarges point by point.
   * \param[in] i_frame_rate frames from one I-frame to the next, >= 1
   */
  PublishedReference(double resolution,
                     const Eigen::Vector3d& crop_min,
                     const Eigen::Vector3d& crop_max,
                     unsigned int i_frame_rate)
  : published::IntensityOctree(resolution)
  , crop_min_(crop_min)
  , crop_max_(crop_max)
  , i_frame_rate_(i_frame_rate)
  {
    if (i_frame_rate == 0)
      throw std::invalid_argument("PublishedReference: i_frame_rate is 0");
    restart();
  }

  /** \brief What the authors' encoder does with an empty cloud instead of sending a
   * frame: it forgets the octree, and with it how far PCL has enlarged it. The next
   * frame is an I-frame. */
  void
  restart()
  {
    const double resolution = getResolution();
    deleteTree();
    setResolution(resolution);
    defineBoundingBox(crop_min_.x(),
                      crop_min_.y(),
                      crop_min_.z(),
                      crop_max_.x(),
                      crop_max_.y(),
                      crop_max_.z());
    restarts_ = true;
  }

  /** \brief Encode the next frame of the stream.
   * \param[in] cloud cropped points; intensity is the point's share of its voxel,
   * already scaled to 0..255. Points that are not finite are skipped. A point outside
   * the crop box makes PCL's octree grow, which costs an I-frame.
   * \return the bytes of one frame
   */
  std::string
  encode(const pcl::PointCloud<pcl::PointXYZI>& cloud)
  {
    const auto depth_before = getTreeDepth();
    for (const auto& point : cloud)
      if (pcl::isFinite(point))
        addPoint(point);

    const bool is_i_frame = restarts_ || frame_count_ % i_frame_rate_ == 0 ||
                            getLeafCount() == 0 || getTreeDepth() != depth_before;
    restarts_ = false;
    ++frame_count_;

    std::ostringstream stream(std::ios::binary);
    stream.write(published::frame_mark.data(),
                 static_cast<std::streamsize>(published::frame_mark.size()));
    published::writeNumber(stream, frame_count_);
    published::writeNumber(stream, static_cast<std::uint8_t>(is_i_frame));
    leaf_count_of_frame_ = getLeafCount();
    if (is_i_frame)
      writeGrid(stream);

    std::vector<char> occupancy;
    intensities_.clear();
    serializeTree(occupancy, !is_i_frame);
    has_empty_branch_ =
        is_i_frame && leaf_count_of_frame_ > 0 &&
        std::find(occupancy.begin(), occupancy.end(), 0) != occupancy.end();
    writeCoded(stream, occupancy);
    writeCoded(stream, intensities_);
    switchBuffers();
    return stream.str();
  }

  std::size_t
  leafCount() const
  {
    return leaf_count_of_frame_;
  }

  /** \brief True if the frame that was encoded last is an I-frame with voxels and a
   * branch that has none below it. */
  bool
  hasEmptyBranch() const
  {
    return has_empty_branch_;
  }

private:
  void
  addPoint(const pcl::PointXYZI& point)
  {
    adoptBoundingBoxToPoint(point);
    pcl::octree::OctreeKey key;
    genOctreeKeyforPoint(point, key);
    const std::size_t leaves_before = getLeafCount();
    published::IntensitySumLeaf* leaf = createLeaf(key);
    // A leaf that is new to this frame may be the one of the frame before, handed over
    // from the other buffer; whether PCL clears it depends on PCL's version.
    if (getLeafCount() != leaves_before)
      leaf->reset();
    leaf->add(point.intensity);
  }

  void
  writeGrid(std::ostream& stream) const
  {
    double min_x, min_y, min_z, max_x, max_y, max_z;
    getBoundingBox(min_x, min_y, min_z, max_x, max_y, max_z);
    published::writeNumber(stream, static_cast<std::uint64_t>(getLeafCount()));
    published::writeNumber(stream, getResolution());
    for (const double bound : {min_x, min_y, min_z, max_x, max_y, max_z})
      published::writeNumber(stream, bound);
  }

  void
  writeCoded(std::ostream& stream, const std::vector<char>& symbols)
  {
    published::writeNumber(stream, static_cast<std::uint64_t>(symbols.size()));
    range_coder_.encodeCharVectorToStream(symbols, stream);
  }

  void
  serializeTreeCallback(published::IntensitySumLeaf& leaf,
                        const pcl::octree::OctreeKey& /*key*/) override
  {
    intensities_.push_back(leaf.byte());
  }

  const Eigen::Vector3d crop_min_;
  const Eigen::Vector3d crop_max_;
  const unsigned int i_frame_rate_;
  bool restarts_ = false; // with the next frame
  std::uint32_t frame_count_ = 0;
  std::size_t leaf_count_of_frame_ = 0;
  bool has_empty_branch_ = false;
  std::vector<char> intensities_;
  pcl::StaticRangeCoder range_coder_;
};

/** \brief Reads the published layout. Trusts its input beyond coarse checks: it exists
 * to read what PublishedReference and the library wrote. */
class PublishedReferenceDecoder : private published::IntensityOctree {
public:
  PublishedReferenceDecoder() : published::IntensityOctree(1.0) {}

  /** \brief Decode one frame from the stream's current position.
   * \return one point per occupied voxel at (key + 0.5) * resolution + min of the
   * octree, metres, in the order of serialization, with intensity 0..255
   * \throws std::runtime_error for bytes that are not a frame, or a P-frame that comes
   * before any I-frame
   */
  pcl::PointCloud<pcl::PointXYZI>
  decode(std::istream& stream)
  {
    std::string mark(published::frame_mark.size(), '\0');
    stream.read(&mark[0], static_cast<std::streamsize>(mark.size()));
    if (mark != published::frame_mark)
      throw std::runtime_error("published frame: no frame mark");
    frame_number_ = published::readNumber<std::uint32_t>(stream);
    is_i_frame_ = published::readNumber<std::uint8_t>(stream) != 0;
    if (is_i_frame_)
      readGrid(stream);
    else if (getTreeDepth() == 0)
      throw std::runtime_error("published frame: no I-frame came before");

    std::vector<char> occupancy = readCoded(stream);
    intensities_ = readCoded(stream);
    cloud_.clear();
    if (!is_i_frame_)
      switchBuffers();
    deserializeTree(occupancy, !is_i_frame_);
    if (cloud_.size() != intensities_.size())
      throw std::runtime_error("published frame: voxels and intensities differ");
    return cloud_;
  }

  pcl::PointCloud<pcl::PointXYZI>
  decode(const std::string& bytes)
  {
    std::istringstream stream(bytes, std::ios::binary);
    return decode(stream);
  }

  /** \brief Number of the frame that was decoded last; the first of a stream is 1. */
  std::uint32_t
  frameNumber() const
  {
    return frame_number_;
  }

  bool
  isIFrame() const
  {
    return is_i_frame_;
  }

private:
  void
  readGrid(std::istream& stream)
  {
    // The leaf count says nothing that the coded vectors do not.
    published::readNumber<std::uint64_t>(stream);
    const double resolution = published::readNumber<double>(stream);
    double bounds[6];
    for (double& bound : bounds)
      bound = published::readNumber<double>(stream);
    if (!(resolution > 0.0))
      throw std::runtime_error("published frame: resolution is not positive");
    // Both buffers must be empty before PCL lets the grid change.
    deleteTree();
    setResolution(resolution);
    defineBoundingBox(bounds[0], bounds[1], bounds[2], bounds[3], bounds[4], bounds[5]);
  }

  std::vector<char>
  readCoded(std::istream& stream)
  {
    constexpr std::uint64_t symbol_limit = std::uint64_t{1} << 28;
    const auto count = published::readNumber<std::uint64_t>(stream);
    if (count > symbol_limit)
      throw std::runtime_error("published frame: implausible number of symbols");
    std::vector<char> symbols(static_cast<std::size_t>(count));
    range_coder_.decodeStreamToCharVector(stream, symbols);
    if (!stream)
      throw std::runtime_error("published frame: the stream ends within a frame");
    return symbols;
  }

  void
  deserializeTreeCallback(published::IntensitySumLeaf& /*leaf*/,
                          const pcl::octree::OctreeKey& key) override
  {
    double min_x, min_y, min_z, max_x, max_y, max_z;
    getBoundingBox(min_x, min_y, min_z, max_x, max_y, max_z);
    pcl::PointXYZI point;
    point.x = static_cast<float>((key.x + 0.5) * getResolution() + min_x);
    point.y = static_cast<float>((key.y + 0.5) * getResolution() + min_y);
    point.z = static_cast<float>((key.z + 0.5) * getResolution() + min_z);
    const std::size_t index = cloud_.size();
    // Missing intensities are found, and refused, once the tree is complete.
    point.intensity =
        index < intensities_.size()
            ? static_cast<float>(static_cast<std::uint8_t>(intensities_[index]))
            : 0.0f;
    cloud_.push_back(point);
  }

  std::uint32_t frame_number_ = 0;
  bool is_i_frame_ = false;
  std::vector<char> intensities_;
  pcl::PointCloud<pcl::PointXYZI> cloud_;
  pcl::StaticRangeCoder range_coder_;
};

} // namespace pcl_ext

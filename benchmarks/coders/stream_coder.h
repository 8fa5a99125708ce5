// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The interface of all coders that are compared.
 */
#pragma once

#include "measuring/workload.h"

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief What a coder's bytes contain of the points. */
enum class Content { VoxelsWithIntensity, Voxels, PointsWithIntensity, Points };

inline const char*
nameOf(Content content)
{
  switch (content) {
  case Content::VoxelsWithIntensity:
    return "voxels, intensity";
  case Content::Voxels:
    return "voxels";
  case Content::PointsWithIntensity:
    return "points, intensity";
  case Content::Points:
    break;
  }
  return "points";
}

/** \brief Encoder and decoder of one stream. What is timed is encode(), from the
 * preprocessed points to bytes in memory, and decode(), from there to a PCL cloud. */
class StreamCoder {
public:
  /** \param[in] name for tables
   * \param[in] content what the bytes contain
   */
  StreamCoder(std::string name, Content content)
  : name_(std::move(name)), content_(content)
  {}

  virtual ~StreamCoder() = default;

  const std::string&
  name() const
  {
    return name_;
  }

  Content
  content() const
  {
    return content_;
  }

  /** \brief What must be done before encode(), and is not timed. */
  virtual void
  prepare(const InputFrame& /* frame */)
  {}

  /** \brief Encodes the next frame.
   * \throws std::runtime_error if the coder refuses it
   */
  virtual void
  encode(const InputFrame& frame) = 0;

  /** \brief Bytes of the frame that was encoded last. */
  std::size_t
  frameBytes() const
  {
    return frame_bytes_;
  }

  /** \brief Decodes the frame that was encoded last.
   * \throws std::runtime_error if that fails
   */
  virtual void
  decode() = 0;

  /** \brief Compares the decoded points with the encoded ones, as far as the bytes
   * contain them.
   * \throws std::runtime_error with the difference
   */
  virtual void
  check(const InputFrame& frame) = 0;

  /** \brief The points that were decoded; after check(). */
  PositionCloud::ConstPtr
  decodedPositions() const
  {
    return positions_;
  }

protected:
  // Set by encode(), and by decode() or check().
  std::size_t frame_bytes_ = 0;
  PositionCloud::Ptr positions_{new PositionCloud};

private:
  std::string name_;
  Content content_;
};

using StreamCoders = std::vector<std::unique_ptr<StreamCoder>>;

/** \brief One coder for each of libraryVariants(). */
void
addLibraryCoders(const Workload& workload, StreamCoders& coders);

void
addLibraryCoder(const Workload& workload, const Variant& variant, StreamCoders& coders);

/** \brief pcl::io::OctreePointCloudCompression in voxel-grid mode. */
void
addPclVoxelGridCoder(const Workload& workload, StreamCoders& coders);

/** \brief The same class keeping all points to a millimetre. */
void
addPclMillimetreCoder(const Workload& workload, StreamCoders& coders);

/** \brief Draco's KD-tree coder at its smallest and at its fastest; nothing if the
 * program was built without Draco. */
void
addDracoCoders(const Workload& workload, StreamCoders& coders);

/** \brief zstd over 16 bytes a point. */
void
addZstdCoder(StreamCoders& coders);

/** \brief All of the above, in this order. */
StreamCoders
makeAllCoders(const Workload& workload);

/** \brief One coder for each effort that keeps all points, with rows and columns of
 * organised clouds; needs InputFrame::raw. */
void
addLibraryPointsCoders(const Workload& workload, StreamCoders& coders);

/** \brief cloudini's program pcd_to_cloudini_converter; what it writes is not decoded.
 * \param[in] program its path; empty: no coder
 */
void
addCloudiniCoder(const Workload& workload,
                 const std::string& program,
                 StreamCoders& coders);

/** \brief Draco's coders of all points as whole numbers, KD-tree and sequential, at
 * their smallest; nothing if the program was built without Draco. */
void
addDracoPointsCoders(const Workload& workload, StreamCoders& coders);

/** \brief PCL's class keeping all points to the workload's resolution. */
void
addPclPointsCoder(const Workload& workload, StreamCoders& coders);

/** \brief zstd over all points as whole numbers, 12 bytes each. */
void
addZstdPointsCoder(const Workload& workload, StreamCoders& coders);

/** \brief Those above that keep all points, coordinates alone, with errors of at most
 * half the workload's resolution in each. */
StreamCoders
makePointsCoders(const Workload& workload, const std::string& cloudini);

/** \brief Coders that start from the cloud in the sensor's frame, which each time is a
 * new copy, as a driver writes it: SensorPreprocessor and each of libraryVariants(),
 * SensorNode at the first of them, and PCL's transformPointCloud, CropBox and voxel
 * grid. What is decoded is checked, not timed.
 * \param[in] stream has a crop box
 */
StreamCoders
makeFromSensorCoders(const InputStream& stream, const Workload& workload);

} // namespace measuring
} // namespace pcl_ext

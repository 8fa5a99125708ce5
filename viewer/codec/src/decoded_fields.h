// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Fields of a decoded frame, with one value for each voxel.
 */
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "viewer/codec/src/result_layouts.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace viewer {

/** \brief Keeps what the results of a call tell of fields. */
class DecodedFields {
public:
  /** \brief Describes a frame's fields, whose names it must keep. */
  void
  describe(const io::VoxelFrame& frame, DecodedFrame& result);

  /** \brief Finds a value of each voxel: that of its field, or what summarizeField()
   * makes of those of its points. None if there is no such field or value. */
  FieldValues
  find(const io::VoxelFrame& frame, std::uint32_t field, std::uint32_t value);

  /** \brief Releases the values. */
  void
  release()
  {
    values_.reset();
  }

private:
  std::vector<DescribedField> descriptions_;
  std::unique_ptr<double[]> values_;
  std::vector<std::uint64_t> of_voxel_;
};

} // namespace viewer
} // namespace pcl_ext

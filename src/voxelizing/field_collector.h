// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "voxelizing/located_points.h"
#include "voxelizing/voxel_locator.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Collects the fields of points that the settings name, in the order of a frame's
 * voxels, or as they come. */
class FieldCollector {
public:
  /** \param[in] settings fields to keep; see StreamSettings::fields */
  explicit FieldCollector(const StreamSettings& settings)
  : settings_(settings.fields)
  , codes_colours_(settings.colour_bits > 0)
  , keeps_points_(settings.keepsPoints())
  {}

  /** \brief Chooses the fields of a cloud.
   * \param[in] offered those that it has
   * \param[in] of_voxels of a frame of voxels, whose colours are means: where points
   * are kept, all fields are those of their colours, too, which a scan has besides
   * \return Ok, or InvalidInput if there is none of a name, one cannot be kept, or
   * there are too many
   */
  CompressionStatus
  select(const std::vector<FieldDescription>& offered, bool of_voxels);

  /** \brief Sets the fields of a frame.
   * \param[in] points the cloud that was voxelized
   * \param[in] locator with the grid of the frame
   * \param[in,out] frame voxels and numbers of points are given
   * \return Ok, or InvalidInput for a value of 2^52 steps or more
   */
  CompressionStatus
  collect(PointBatches& points, const VoxelLocator& locator, VoxelFrame& frame);

  /** \brief Appends the values of some points of a batch.
   * \param[in] indices of these
   * \param[in,out] numbers of each selected field
   */
  void
  readPoints(const PointView& points,
             const std::vector<std::uint32_t>& indices,
             std::vector<std::vector<std::uint64_t>>& numbers) const;

  void
  releaseMemory();

  /** \brief A field that was selected. */
  struct Selected {
    FieldDescription description;
    std::size_t index; ///< among those that the cloud offers
  };

  /** \brief Whether the settings mean all fields. */
  bool
  meansAll() const;

  /** \brief Fields of the cloud that all_fields stands for and that cannot be kept, with
   * commas between them; empty if there are none. */
  const std::string&
  leftOut() const
  {
    return left_out_;
  }

  /** \brief Whether all_fields stands for colours with an alpha, which a scan does not
   * have. */
  bool
  losesAlpha() const
  {
    return loses_alpha_;
  }

  const std::vector<Selected>&
  selected() const
  {
    return selected_;
  }

  /** \brief Values of a point in the selected fields. */
  std::size_t
  valuesOfPoint() const
  {
    std::size_t values = 0;
    for (const Selected& field : selected_)
      values += field.description.count;
    return values;
  }

private:
  /** \brief A point of the cloud. */
  struct Entry {
    std::uint64_t key;   // of its voxel
    std::uint32_t point; // among those that are located
  };

  friend std::uint64_t
  keyOf(const Entry& entry)
  {
    return entry.key;
  }

  void
  readBatch(const PointView& points, const VoxelLocator& locator, bool of_voxels);

  void
  sortPointsOfVoxels();

  void
  arrange(std::size_t field, FrameField& arranged) const;

  void
  summarize(std::size_t field, FrameField& summary);

  std::vector<FieldSetting> settings_;
  bool codes_colours_;
  bool keeps_points_;
  std::vector<Selected> selected_;
  std::string left_out_;
  bool loses_alpha_ = false;
  // Of the current frame; members so that their memory is reused.
  LocatedPoints located_;
  std::vector<Entry> entries_;
  std::vector<Entry> spare_;
  std::vector<std::vector<std::uint64_t>> numbers_; // of each field, by located point
  std::vector<std::uint64_t> of_voxel_;
  std::vector<std::uint32_t> batch_; // indices of located points
};

/** \brief Checks that a field has no values of 2^52 steps or more.
 * \return Ok, or InvalidInput
 */
CompressionStatus
checkNumbers(const FrameField& field);

} // namespace pcl_ext::PCL_EXT_ABI::io

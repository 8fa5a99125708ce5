// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/frame_preparation.h"

#include "codec/frame_failures.h"

#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Sets what the header of a P-frame has of the frames before. */
CompressionStatus
completeHeader(const FrameContext& context)
{
  if (context.header.effort != context.last.effort)
    return corruptFrame("a P-frame of another effort than its I-frame");
  // It says whether there are colours, and not of how many bits.
  supplement::Content content = context.header.content;
  const bool has_colours = content.colour_bits > 0;
  content.colour_bits = context.last.content.colour_bits;
  if (!context.header.is_of_changes &&
      (content != context.last.content || has_colours != (content.colour_bits > 0)))
    return corruptFrame("a P-frame of another content than its I-frame");
  context.last.complete(context.header);
  if (!context.header.placement)
    return {};
  if (!isConsistent(context.header.scan) ||
      !context.header.scan.mayFollow(context.last.scan))
    return corruptFrame("invalid placement of a scan");
  return checkPixelCount(context.header.scan, context.limits);
}

/** \brief Sets which fields a frame has. */
CompressionStatus
prepareFields(const FrameContext& context, VoxelFrame& frame)
{
  const std::size_t count =
      context.header.content.has_fields ? context.header.fields.size() : 0;
  frame.fields.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    static_cast<FieldDescription&>(frame.fields[i]) = context.header.fields[i];
  frame.viewpoint = context.header.viewpoint;
  const std::uint64_t values =
      count == 0 ? 0 : fieldValuesOf(context.header, context.header.fields);
  if (values > context.limits.max_field_values)
    return {CompressionCode::LimitExceeded,
            std::to_string(values) + " values of fields exceed the limit of " +
                std::to_string(context.limits.max_field_values)};
  return {};
}

/** \brief Sets what a frame has besides its voxels. */
CompressionStatus
prepareContent(const FrameContext& context, VoxelFrame& frame)
{
  frame.colour_bits = context.header.content.colour_bits;
  frame.has_point_counts = context.header.content.has_point_counts;
  if (!frame.hasIntensities())
    frame.intensities.clear();
  if (frame.colour_bits == 0)
    frame.colours.clear();
  if (!frame.has_point_counts)
    frame.point_counts.clear();
  if (CompressionStatus status = prepareFields(context, frame); !status.ok())
    return status;
  frame.points = FramePoints();
  frame.layout = context.header.layout;
  if (context.header.content.hasVoxels()) {
    context.coarse_voxels.grid = frame.grid;
    context.coarse_voxels.grid.depth -= context.header.content.refinement_levels;
    context.coarse_voxels.intensity_scale.bits = 0;
  }
  return {};
}

/** \brief Reads the depth model at the beginning of a payload. */
CompressionStatus
readPayloadsDepthModel(const FrameContext& context, const std::uint8_t*& payload)
{
  if (!context.header.is_i_frame && !context.last.depth_model)
    return corruptFrame("a P-frame with a depth model, its I-frame without");
  if (context.header.intensity_scale.bits == 0 || context.header.content.hasVoxels())
    return corruptFrame("a depth model without intensities that it predicts");
  if (!readDepthModel(payload, context.header.depth_model.emplace()))
    return corruptFrame("invalid depth model");
  payload += depth_model_size;
  return {};
}

} // namespace

CompressionStatus
prepareFrame(const FrameContext& context,
             const std::uint8_t*& payload,
             VoxelFrame& frame)
{
  if (!context.header.is_i_frame)
    if (CompressionStatus status = completeHeader(context); !status.ok())
      return status;
  frame.grid = context.header.grid;
  frame.intensity_scale = context.header.intensity_scale;
  if (CompressionStatus status = prepareContent(context, frame); !status.ok())
    return status;
  if (context.header.has_depth_model)
    if (CompressionStatus status = readPayloadsDepthModel(context, payload);
        !status.ok())
      return status;
  frame.depth_model = context.header.depth_model;
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::io

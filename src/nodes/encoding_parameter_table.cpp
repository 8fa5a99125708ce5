// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>
#include <pcl_ext/nodes/node_parameters.h>

#include "nodes/parameter_access.h"

namespace pcl_ext {
namespace nodes {

namespace {

using Descriptions = std::vector<ParameterDescription>;

void
describeGrid(Descriptions& parameters)
{
  parameters.push_back(numberParameter("resolution",
                                       "m",
                                       io::EncoderSettings().resolution,
                                       io::smallest_resolution,
                                       io::largest_resolution,
                                       "Edge of a voxel."));
}

void
describeLaw(Descriptions& parameters)
{
  parameters.push_back(wordParameter(
      "intensity",
      nameOf(lawChoices(), LawChoice()),
      lawChoices(),
      "Intensity of a voxel: the number of its points; the covered share of a voxel "
      "face (255: all), by two laws, quadratic and linear; native, the sensor's own "
      "intensity; none, positions alone; automatic, native for clouds with the field "
      "of intensity_field, else none."));
  parameters.push_back(textParameter("intensity_field",
                                     SensorNodeSettings().intensity_field,
                                     "Field of the clouds that native reads."));
}

void
describeSensor(Descriptions& parameters)
{
  parameters.push_back(
      wordParameter("sensor",
                    "",
                    named_sensors,
                    "Sensor by its name, which quadratic and linear need, unless it is "
                    "described by the next four parameters."));
  constexpr double widest = 179.9; // degrees; the tangent of its half is finite
  constexpr double narrowest = 0.1;
  constexpr std::int32_t most_pixels = 65536;
  const char* const field_of_view = "field of view of the sensor; 0: not set.";
  const char* const image = "of the sensor's depth image; 0: not set.";
  parameters.push_back(numberParameter("sensor_fov_x_deg",
                                       "degrees",
                                       0.0,
                                       narrowest,
                                       widest,
                                       std::string("Horizontal ") + field_of_view));
  parameters.push_back(numberParameter("sensor_fov_y_deg",
                                       "degrees",
                                       0.0,
                                       narrowest,
                                       widest,
                                       std::string("Vertical ") + field_of_view));
  parameters.push_back(countParameter(
      "sensor_columns", "pixels", 0, 1, most_pixels, std::string("Width ") + image));
  parameters.push_back(countParameter(
      "sensor_rows", "pixels", 0, 1, most_pixels, std::string("Height ") + image));
}

void
describeStream(Descriptions& parameters)
{
  const io::EncoderSettings defaults;
  parameters.push_back(wordParameter("effort",
                                     nameOf(io::efforts, defaults.effort),
                                     io::efforts,
                                     "Time against size; version1 only."));
  parameters.push_back(
      wordParameter("format",
                    nameOf(io::stream_formats, defaults.format),
                    io::stream_formats,
                    "Bitstream: this library's own, or that which the paper's authors "
                    "published."));
  parameters.push_back(
      countParameter("i_frame_rate",
                     "frames",
                     defaults.i_frame_rate,
                     0,
                     largest_integer,
                     "Frames from one I-frame to the next; 0 and 1: I-frames only."));
}

void
describeIntensities(Descriptions& parameters)
{
  const io::EncoderSettings defaults;
  parameters.push_back(wordParameter(
      "aggregation",
      nameOf(io::aggregations, defaults.aggregation),
      io::aggregations,
      "Intensity of several points in a voxel; automatic: mean for native "
      "in version1, else sum."));
  parameters.push_back(
      countParameter("intensity_bits",
                     "bits",
                     defaults.intensity_bits,
                     0,
                     16,
                     "Bits of an intensity; 0: automatic; published: 0 or 8."));
  parameters.push_back(
      numberParameter("intensity_range",
                      "of the intensity",
                      defaults.intensity_range,
                      0.0,
                      largest_intensity,
                      "Top of the scale; 0: automatic; published: 0 or 255."));
  parameters.push_back(
      wordParameter("intensity_curve",
                    nameOf(io::intensity_curves, defaults.intensity_curve),
                    io::intensity_curves,
                    "Steps of the scale; companded: small intensities are exact, large "
                    "ones rounded; published: linear."));
  parameters.push_back(
      countParameter("colour_bits",
                     "bits",
                     defaults.colour_bits,
                     0,
                     8,
                     "Bits of a colour channel, for clouds with colours, which can "
                     "double the bytes of a frame; 0: none; published: none."));
}

void
describePoints(Descriptions& parameters)
{
  const io::EncoderSettings defaults;
  parameters.push_back(
      flagParameter("keep_point_counts",
                    defaults.keep_point_counts,
                    "Send the number of points of each voxel, so that a decoded cloud "
                    "has as many; version1 only."));
  parameters.push_back(textParameter(
      "fields",
      "",
      "Further fields to keep, as ring,time:1e-6 (exact; in steps), or all: with "
      "keep_point_counts of each point, else the mean of a voxel, or of integers the "
      "most frequent; version1 only; not with temporal_filter; '': none."));
  parameters.push_back(
      flagParameter("coarsen_wide_clouds",
                    defaults.coarsen_wide_clouds,
                    "Larger voxels for clouds wider than 2^21 of them, instead of "
                    "leaving points out; not for quadratic and linear."));
  parameters.push_back(countParameter(
      "threads",
      "",
      defaults.threads,
      1,
      256,
      "Most threads that voxelize a cloud; the bytes do not depend on it."));
}

void
describeFilters(Descriptions& parameters)
{
  ParameterDescription crop_box;
  crop_box.name = "crop_box";
  crop_box.unit = "m";
  crop_box.default_value = std::vector<double>();
  crop_box.list_size = 6;
  crop_box.description =
      "Box [x0, y0, z0, x1, y1, z1] in the global frame of a node, or "
      "in the frame of the clouds of a transport, outside of which "
      "points are left out; []: none.";
  parameters.push_back(crop_box);
  parameters.push_back(flagParameter("remove_outliers",
                                     SensorNodeSettings().outlier_removal.has_value(),
                                     "Remove noise before it is encoded: of lidars "
                                     "that turn points, judged by the rays "
                                     "around them, of other sensors voxels, judged by "
                                     "their surroundings in this frame "
                                     "and the last ones."));
  parameters.push_back(descriptionOf(noiseParameters(), "min_log_odds"));
  parameters.push_back(
      countParameter("temporal_filter",
                     "frames",
                     io::EncoderSettings().temporal_filter,
                     TemporalVoxelFilter::least_frames,
                     TemporalVoxelFilter::most_frames,
                     "Frames over which surfaces are told from noise before they are "
                     "encoded, 8 for 10 "
                     "to 30 Hz, so that a still scene takes few bytes; lossy; not with "
                     "keep_point_counts; 0: off."));
}

void
describeBudget(Descriptions& parameters)
{
  const io::RateSettings defaults;
  parameters.push_back(
      numberParameter("max_rate",
                      "bit/s",
                      defaults.max_rate,
                      io::least_max_rate,
                      io::most_max_rate,
                      "Bits that the frames of any second may take; where they would "
                      "take more, filters, bits and voxels become coarser, and clouds "
                      "without room are left out; 0: no limit."));
  parameters.push_back(
      numberParameter("rate_buffer",
                      "s",
                      defaults.rate_buffer,
                      0.01,
                      1.0,
                      "How long, at max_rate, a frame may take and wait to be sent."));
  parameters.push_back(
      numberParameter("max_encode_ms",
                      "ms",
                      defaults.max_encode_ms,
                      0.1,
                      1e4,
                      "Time that encoding may take, on average; effort, then voxels "
                      "follow, and max_rate may raise the effort; 0: no limit."));
  parameters.push_back(
      countParameter("rate_temporal_filter",
                     "frames",
                     defaults.rate_temporal_filter,
                     0,
                     TemporalVoxelFilter::most_frames,
                     "Strongest temporal_filter that max_rate may choose, where the "
                     "sensor rests; 0: none."));
  parameters.push_back(countParameter("rate_doublings",
                                      "",
                                      defaults.rate_doublings,
                                      0,
                                      8,
                                      "How often max_rate and max_encode_ms may double "
                                      "the edge of a voxel."));
  parameters.push_back(numberParameter(
      "rate_sent_share",
      "",
      defaults.rate_sent_share,
      0.1,
      1.0,
      "Share of the clouds that max_rate sends, leaving others out, before it "
      "doubles the edge of a voxel; 1: for those that need each cloud."));
}

Descriptions
describeEncodingParameters()
{
  Descriptions parameters;
  describeGrid(parameters);
  describeLaw(parameters);
  describeSensor(parameters);
  describeStream(parameters);
  describeIntensities(parameters);
  describePoints(parameters);
  describeFilters(parameters);
  describeBudget(parameters);
  return parameters;
}

} // namespace

const std::vector<ParameterDescription>&
encodingParameters()
{
  static const Descriptions parameters = describeEncodingParameters();
  return parameters;
}

} // namespace nodes
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/encode_summary.h"

#include "console/exit_status.h"
#include "console/printable_text.h"
#include "measuring/markdown_table.h"
#include "options/text_values.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <sstream>

namespace pcl_ext::tools {

using measuring::formatted;

namespace {

/** \brief How many points are in order, and how many in voxels. */
std::string
describePoints(const EncodedSums& sums, const io::EncoderSettings& settings)
{
  const double smallest_edge =
      sums.frames > 0 ? sums.smallest_edge : settings.resolution;
  std::ostringstream edge;
  edge << smallest_edge;
  constexpr double tolerance = 1.0 + 1e-6;
  if (sums.largest_edge > tolerance * smallest_edge)
    edge << " m to " << sums.largest_edge;
  edge << " m";
  // Else other settings make edges larger, too.
  if (sums.largest_edge > tolerance * settings.resolution &&
      !settings.coarsen_wide_clouds && settings.max_rate == 0.0 &&
      settings.max_encode_ms == 0.0)
    edge << ", the step of coordinates";
  const std::size_t in_voxels = sums.encoded_points - sums.points_in_order;
  std::string text;
  if (sums.points_in_order > 0)
    text = counted(sums.points_in_order, "point") + " " + sums.orders.describe() +
           (in_voxels > 0 ? ", and " : ", edge " + edge.str());
  if (sums.points_in_order > 0 && in_voxels == 0)
    return text;
  // Points are counted before voxels are removed, hidden and held.
  const std::size_t measured = sums.occupiedVoxels() + sums.outliers;
  const bool are_same = sums.outliers + sums.hidden_voxels + sums.held_voxels == 0;
  text += counted(in_voxels, "point") + " in " + counted(measured, "voxel") + " of " +
          edge.str();
  if (measured > 0)
    text +=
        " (" +
        formatted(static_cast<double>(in_voxels) / static_cast<double>(measured), 1) +
        " points a voxel)";
  if (!are_same)
    text += ", " + counted(sums.voxels, "voxel") + " in frames";
  return text;
}

/** \brief What was encoded.
 * \param[in] bytes_a_second what all streams take together; 0: unknown
 */
std::string
describeEncoded(const EncodedSums& sums,
                const EncodingOptions& options,
                double bytes_a_second)
{
  const auto encoded_points = static_cast<double>(sums.encoded_points);
  std::string text = describePoints(sums, options.codec());
  if (sums.clouds_left_out > 0)
    text += ", " + counted(sums.clouds_left_out, "cloud") + " left out for --max-rate";
  if (sums.all_points > sums.points)
    text += ", " + counted(sums.all_points - sums.points, "point") +
            " left out as not finite";
  if (sums.points_outside_grid > 0)
    text += ", " + counted(sums.points_outside_grid, "point") +
            " left out outside the grid of voxels";
  if (sums.pointsOutsideBox() > 0)
    text +=
        ", " + counted(sums.pointsOutsideBox(), "point") + " left out outside the box";
  text += ", " + counted(sums.bytes, "byte");
  if (bytes_a_second > 0.0)
    text += " (" + formatted(bytes_a_second, 0) + " bytes/s)";
  // What fields take is compared with the points of the clouds.
  const double of_point = options.codec().fields.empty() || sums.encoded_points == 0
                              ? 16.0
                              : static_cast<double>(sums.point_bytes) / encoded_points;
  text += ", ratio " +
          formatted(of_point * encoded_points / static_cast<double>(sums.bytes), 1) +
          " against " + formatted(of_point, 0) + " bytes a point" +
          (options.codec().fields.empty() ? " (x, y, z, intensity)" : " of the clouds");
  if (sums.judged_points > 0)
    text += ", " + formatted(static_cast<double>(sums.point_outliers), 0) + " of " +
            counted(sums.judged_points, "point") +
            " removed as outliers by a lidar's rays";
  const bool were_none_judged =
      sums.judged_points == 0 && sums.frames_with_outliers == 0;
  if (options.removesOutliers() && (sums.judged_by != 0 || were_none_judged)) {
    text += ", " + formatted(static_cast<double>(sums.outliers), 0) + " of " +
            counted(sums.outliers + sums.occupiedVoxels(), "voxel") +
            " removed as outliers";
    const char* separator = ", judged by ";
    for (const auto& [unit, name] : density_units)
      if ((sums.judged_by >> static_cast<unsigned int>(unit) & 1u) != 0) {
        text += std::string(separator) + name;
        separator = " and ";
      }
  }
  if (options.codec().temporal_filter != 0 || sums.hidden_voxels > 0 ||
      sums.held_voxels > 0)
    text += ", " + counted(sums.held_voxels, "voxel") + " held and " +
            formatted(static_cast<double>(sums.hidden_voxels), 0) +
            " hidden by the temporal filter" +
            (sums.moving_frames == 0
                 ? ""
                 : ", which leaves " + counted(sums.moving_frames, "frame") + " of " +
                       formatted(static_cast<double>(sums.frames), 0) +
                       " as measured, as the sensor moves");
  return text;
}

} // namespace

std::string
describeBag(const std::string& output,
            const BagSummary& summary,
            const EncodingOptions& options,
            const std::string& interruption)
{
  std::string line = output + ": " + counted(summary.sums.frames, "frame");
  const auto streams =
      std::count_if(summary.streams.begin(),
                    summary.streams.end(),
                    [](const auto& stream) { return stream.frames > 0; });
  if (streams > 1)
    line += " of " + std::to_string(streams) + " streams";
  line += ", " + describeEncoded(summary.sums, options, summary.bytes_a_second);
  if (summary.other_messages > 0)
    line += ", " + counted(summary.other_messages, "other message") + " passed through";
  if (summary.failures > 0)
    line += ", " + formatted(static_cast<double>(summary.failures), 0) + " failed";
  return line + interruption;
}

std::string
statusName(int exit_status)
{
  return exit_status == all_done      ? "done"
         : exit_status == interrupted ? "interrupted"
                                      : "incomplete";
}

std::string
asText(const nlohmann::ordered_json& json)
{
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

nlohmann::ordered_json
toJson(const std::vector<std::string>& inputs,
       const std::string& output,
       const std::string& status,
       const BagSummary& summary,
       const std::vector<std::string>& errors)
{
  using Json = nlohmann::ordered_json;
  const EncodedSums& sums = summary.sums;
  Json json = {{"inputs", Json::array()},
               {"output", printable(output)},
               {"status", status},
               {"frames", sums.frames},
               {"frame_bytes", sums.bytes},
               {"failures", summary.failures},
               {"clouds_left_out", sums.clouds_left_out},
               {"points", sums.all_points},
               {"points_encoded", sums.encoded_points},
               {"points_not_finite", sums.all_points - sums.points},
               {"points_outside_box", sums.pointsOutsideBox()},
               {"points_outside_grid", sums.points_outside_grid},
               {"points_removed", sums.point_outliers},
               {"voxels", sums.voxels},
               {"voxels_removed", sums.outliers},
               {"voxels_hidden", sums.hidden_voxels},
               {"voxels_held", sums.held_voxels},
               {"frames_with_outliers", sums.frames_with_outliers},
               {"smallest_edge", sums.frames > 0 ? Json(sums.smallest_edge) : Json()},
               {"largest_edge", sums.frames > 0 ? Json(sums.largest_edge) : Json()},
               {"streams", Json::array()},
               {"errors", Json::array()}};
  for (const std::string& input : inputs)
    json["inputs"].push_back(printable(input));
  for (const StreamSummary& stream : summary.streams)
    json["streams"].push_back({{"name", printable(stream.name)},
                               {"frames", stream.frames},
                               {"bytes", stream.bytes},
                               {"failures", stream.failures}});
  for (const std::string& error : errors)
    json["errors"].push_back(printable(error));
  return json;
}

} // namespace pcl_ext::tools

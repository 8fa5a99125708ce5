#include "commands/encode_summary.h"

#include "measuring/markdown_table.h"
#include "options/text_values.h"

#include <sstream>

namespace pcl_ext {
namespace tools {

using measuring::formatted;

std::string
describeEncoded(const EncodedSums& sums,
                const EncodingOptions& options,
                double bytes_a_second)
{
  std::ostringstream edge;
  edge << options.codec().resolution;
  const auto encoded_points = static_cast<double>(sums.encoded_points);
  std::string text = counted(sums.encoded_points, "point") + " in " +
                     counted(sums.voxels, "voxel") + " of " + edge.str() + " m" +
                     (options.hasRegions() ? " and more" : "");
  if (constexpr double tolerance = 1.0 + 1e-6;
      sums.largest_edge > tolerance * options.codec().resolution) {
    std::ostringstream largest;
    largest << sums.largest_edge;
    text += " to " + largest.str() + " m";
  }
  const std::size_t occupied = sums.voxels + sums.hidden_voxels - sums.held_voxels;
  if (occupied > 0)
    text += " (" + formatted(encoded_points / static_cast<double>(occupied), 1) +
            " points a voxel)";
  if (sums.clouds_left_out > 0)
    text += ", " + counted(sums.clouds_left_out, "cloud") + " left out for --max-rate";
  if (sums.all_points > sums.points)
    text += ", " + counted(sums.all_points - sums.points, "point") +
            " left out as not finite";
  if (const std::size_t kept = sums.points - sums.point_outliers;
      kept > sums.encoded_points)
    text += ", " + counted(kept - sums.encoded_points, "point") +
            (options.hasRegions() ? " left out beyond box, grid or regions"
                                  : " left out beyond box or grid");
  text += ", " + counted(sums.bytes, "byte");
  if (bytes_a_second > 0.0)
    text += " (" + formatted(bytes_a_second, 0) + " bytes/s)";
  // What fields take is compared with the points of the clouds.
  const double of_point = options.codec().fields.empty() || sums.encoded_points == 0
                              ? 16.0
                              : static_cast<double>(sums.point_bytes) / encoded_points;
  text += ", ratio " +
          formatted(of_point * encoded_points / static_cast<double>(sums.bytes), 1) +
          " to " + formatted(of_point, 0) + " bytes a point" +
          (options.codec().fields.empty() ? "" : " of the clouds");
  if (sums.judged_points > 0)
    text += ", " + formatted(static_cast<double>(sums.point_outliers), 0) + " of " +
            counted(sums.judged_points, "point") +
            " removed as outliers by a lidar's rays";
  if (options.removesOutliers() && (sums.judged_by != 0 || sums.judged_points == 0)) {
    text += ", " + formatted(static_cast<double>(sums.outliers), 0) + " of " +
            counted(sums.outliers + occupied, "voxel") + " removed as outliers";
    const char* separator = ", judged by ";
    for (const auto& [unit, name] : density_units)
      if ((sums.judged_by >> static_cast<unsigned int>(unit) & 1u) != 0) {
        text += std::string(separator) + name;
        separator = " and ";
      }
  }
  if (options.codec().temporal_filter != 0)
    text += ", " + counted(sums.held_voxels, "voxel") + " held and " +
            formatted(static_cast<double>(sums.hidden_voxels), 0) +
            " hidden by the temporal filter";
  return text;
}

} // namespace tools
} // namespace pcl_ext

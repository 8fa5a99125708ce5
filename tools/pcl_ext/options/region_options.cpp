#include "options/region_options.h"

#include <pcl_ext/compression/voxel_regions.h>

#include "options/options.h"
#include "options/text_values.h"

#include <cmath>
#include <limits>
#include <sstream>
#include <string>

namespace pcl_ext {
namespace tools {

namespace {

std::pair<io::BoundingBox, double>
parseRegion(const std::string& text)
{
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos)
    throw UsageError("--region: '" + text +
                     "' has no edge; it must be x0,y0,z0,x1,y1,z1=EDGE, in metres");
  const std::vector<double> edge = parseNumbers("region", text.substr(equals + 1));
  if (edge.size() != 1)
    throw UsageError("--region: there must be one edge after =, metres");
  return {parseBox("region", text.substr(0, equals)), edge[0]};
}

/** \brief How often a resolution is doubled to an edge. */
unsigned int
doublingsTo(double edge, double resolution)
{
  for (unsigned int doublings = 0; doublings <= io::most_region_levels; ++doublings)
    if (std::abs(std::ldexp(resolution, static_cast<int>(doublings)) - edge) <=
        1e-6 * edge)
      return doublings;
  std::ostringstream message;
  message << "--region: the edge is " << edge << " m; it must be --resolution ("
          << resolution << " m) times 1, 2, 4, 8, 16 or 32";
  throw UsageError(message.str());
}

} // namespace

void
RegionOptions::add(CLI::App& app)
{
  CLI::Option* const region =
      app.add_option_function<std::vector<std::string>>(
             "--region",
             [this](const std::vector<std::string>& texts) {
               for (const std::string& text : texts)
                 boxes_.push_back(parseRegion(text));
             },
             "x0,y0,z0,x1,y1,z1=EDGE: voxels of an edge of their own in a box, the "
             "resolution times a power of two; the first box counts")
          ->expected(1)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
          ->type_name("BOX=EDGE");
  addChoice(app, "--region-frame", io::region_frames, frame_, "of all regions")
      ->needs(region);
  addChoice(app,
            "--outside",
            io::outsides_of_regions,
            settings_.outside,
            "points outside of all regions")
      ->needs(region);
  CLI::Option* const beyond =
      addNumber(app,
                "--coarser-beyond",
                settings_.coarser_beyond,
                0.0,
                std::numeric_limits<double>::max(),
                "M",
                "outside of regions twice the edge from so far from the sensor on, and "
                "again at each doubling of the distance; 0: off");
  addNumber(app,
            "--most-doublings",
            settings_.most_doublings,
            1u,
            io::most_region_levels,
            "N",
            "by --coarser-beyond")
      ->needs(beyond);
}

io::RegionSettings
RegionOptions::settingsAt(double resolution) const
{
  io::RegionSettings settings = settings_;
  for (const auto& [box, edge] : boxes_)
    settings.boxes.push_back({box, doublingsTo(edge, resolution), frame_});
  return settings;
}

} // namespace tools
} // namespace pcl_ext

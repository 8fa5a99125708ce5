#include "stream_bytes.h"

#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "measuring/result_file.h"
#include "simulator/crop_box.h"
#include "simulator/robot_cell.h"

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>

#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief A node with its settings, and the sums of what it sent. */
struct Sender {
  std::string coding; ///< law and effort
  std::string filter;
  bool sends_surfaces; ///< only points of surfaces
  nodes::SensorNode node;
  double voxels = 0.0;
  double bytes = 0.0;
};

nodes::SensorNodeSettings
nodeSettings(double resolution, IntensityLaw law, io::Effort effort)
{
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = resolution;
  settings.compression.effort = effort;
  settings.law = law;
  settings.sensor = runtimeSensor(KinectV2());
  settings.crop_box = cell::cropBox();
  return settings;
}

/** \brief Senders of one law and effort; the first one has no filter. */
void
addSenders(const std::string& coding,
           const nodes::SensorNodeSettings& settings,
           std::vector<Sender>& senders)
{
  senders.push_back({coding, "none", false, nodes::SensorNode(settings)});
  for (const auto& [name, log_odds] :
       {std::pair("log-odds 0", 0.0f), std::pair("log-odds 2.5", 2.5f)}) {
    nodes::SensorNodeSettings filtered = settings;
    filtered.outlier_removal.emplace();
    filtered.outlier_removal->min_log_odds = log_odds;
    senders.push_back({coding, name, false, nodes::SensorNode(filtered)});
  }
  senders.push_back({coding, "the truth", true, nodes::SensorNode(settings)});
}

void
send(Sender& sender, const pcl::PCLPointCloud2& cloud, const WorldPose& pose)
{
  std::vector<std::uint8_t> bytes;
  if (const auto status = sender.node.encode(cloud, pose, bytes); !status.hasFrame())
    throw std::runtime_error(status.message());
  sender.bytes += static_cast<double>(bytes.size());
  sender.voxels += static_cast<double>(sender.node.statistics().frame.coding.voxels);
}

void
removeNoise(cell::CellFrame& frame)
{
  for (std::size_t i = 0; i < frame.cloud.size(); ++i)
    if (frame.truth[i] != cell::PointTruth::Surface)
      frame.cloud[i].x = std::numeric_limits<float>::quiet_NaN();
}

} // namespace

void
measureStreamBytes(std::uint32_t seed,
                   unsigned int sensor,
                   std::uint32_t frames,
                   double resolution,
                   measuring::ResultFile& results)
{
  std::vector<Sender> senders;
  for (const auto law : {IntensityLaw::Count, IntensityLaw::Quadratic})
    for (const auto effort : {io::Effort::Fast, io::Effort::Balanced})
      addSenders(nameOf(law) + (effort == io::Effort::Fast ? " fast" : " balanced"),
                 nodeSettings(resolution, law, effort),
                 senders);
  cell::RobotCell cell(seed);
  const WorldPose pose(cell.sensorPose(sensor));
  cell::CellFrame frame;
  for (std::uint32_t i = 0; i < frames; ++i) {
    cell.capture(sensor, i, frame);
    pcl::PCLPointCloud2 cloud;
    pcl::toPCLPointCloud2(frame.cloud, cloud);
    removeNoise(frame);
    pcl::PCLPointCloud2 surfaces;
    pcl::toPCLPointCloud2(frame.cloud, surfaces);
    for (Sender& sender : senders)
      send(sender, sender.sends_surfaces ? surfaces : cloud, pose);
  }
  double bytes_without_filter = 0.0;
  for (const Sender& sender : senders) {
    if (sender.filter == "none")
      bytes_without_filter = sender.bytes;
    const measuring::Subject subject{"noise_bytes:" + sender.coding,
                                     std::to_string(sensor),
                                     sender.filter,
                                     resolution};
    results.add(subject, "voxels", sender.voxels / frames, frames);
    results.add(subject, "bytes", sender.bytes / frames, frames);
    results.add(subject,
                "less_percent",
                100.0 * (1.0 - sender.bytes / bytes_without_filter),
                frames);
  }
}

} // namespace noise
} // namespace pcl_ext

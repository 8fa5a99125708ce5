#include "stream_bytes.h"

#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "measuring/markdown_table.h"
#include "simulator/crop_box.h"
#include "simulator/robot_cell.h"

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>

#include <result_file.h>

#include <limits>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief A node and what it sent. */
struct Sender {
  nodes::SensorNode node;
  std::size_t voxels = 0;
  std::size_t bytes = 0;
};

nodes::SensorNodeSettings
nodeSettings(double resolution, IntensityLaw law, io::Effort effort)
{
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = resolution;
  settings.compression.effort = effort;
  settings.law = law;
  settings.sensor.emplace(
      KinectV2::fov_x_deg, KinectV2::fov_y_deg, KinectV2::columns, KinectV2::rows);
  settings.crop_box = cell::cropBox();
  return settings;
}

/** \brief What a sender does not remove; none: it removes nothing. */
using LogOdds = std::optional<float>;
const std::vector<LogOdds> filters = {std::nullopt, 0.0f, 2.5f};

/** \brief A filter that knows the truth: what the best one could save. */
void
removeNoise(cell::CellFrame& frame)
{
  for (std::size_t i = 0; i < frame.cloud.size(); ++i)
    if (frame.truth[i] != cell::PointTruth::Surface)
      frame.cloud[i].x = std::numeric_limits<float>::quiet_NaN();
}

const std::vector<std::pair<std::string, IntensityLaw>> node_laws = {
    {"count", IntensityLaw::Count}, {"quadratic", IntensityLaw::Quadratic}};
const std::vector<std::pair<std::string, io::Effort>> efforts = {
    {"fast", io::Effort::Fast}, {"balanced", io::Effort::Balanced}};

/** \brief Senders by law, effort and filter; the last of each knows the truth. */
std::vector<Sender>
makeSenders(double resolution)
{
  std::vector<Sender> senders;
  for (const auto& [law_name, law] : node_laws)
    for (const auto& [effort_name, effort] : efforts) {
      nodes::SensorNodeSettings settings = nodeSettings(resolution, law, effort);
      for (const LogOdds& least : filters) {
        settings.outlier_removal.reset();
        if (least) {
          settings.outlier_removal.emplace();
          settings.outlier_removal->min_log_odds = *least;
        }
        senders.push_back({nodes::SensorNode(settings)});
      }
      settings.outlier_removal.reset();
      senders.push_back({nodes::SensorNode(settings)});
    }
  return senders;
}

void
send(Sender& sender, const pcl::PCLPointCloud2& cloud, const WorldPose& pose)
{
  std::vector<std::uint8_t> bytes;
  if (const auto status = sender.node.encode(cloud, pose, bytes); !status.hasFrame())
    throw std::runtime_error(status.message());
  sender.bytes += bytes.size();
  sender.voxels += sender.node.statistics().frame.coding.voxels;
}

std::vector<SentBytes>
bytesOf(const std::vector<Sender>& senders, std::uint32_t frames)
{
  const std::vector<std::string> names = {
      "none", "log-odds 0", "log-odds 2.5", "the truth"};
  std::vector<SentBytes> sent;
  auto sender = senders.begin();
  for (const auto& [law_name, law] : node_laws)
    for (const auto& [effort_name, effort] : efforts) {
      const auto all_bytes = static_cast<double>(sender->bytes);
      for (const std::string& name : names) {
        const auto bytes = static_cast<double>(sender->bytes);
        sent.push_back({law_name,
                        effort_name,
                        name,
                        static_cast<double>(sender->voxels) / frames,
                        bytes / frames,
                        100.0 * (1.0 - bytes / all_bytes)});
        ++sender;
      }
    }
  return sent;
}

} // namespace

std::vector<SentBytes>
measureStreamBytes(std::uint32_t seed,
                   unsigned int sensor,
                   std::uint32_t frames,
                   double resolution)
{
  cell::RobotCell cell(seed);
  const WorldPose pose(cell.sensorPose(sensor));
  std::vector<Sender> senders = makeSenders(resolution);
  cell::CellFrame frame;
  for (std::uint32_t i = 0; i < frames; ++i) {
    cell.capture(sensor, i, frame);
    pcl::PCLPointCloud2 cloud;
    pcl::toPCLPointCloud2(frame.cloud, cloud);
    removeNoise(frame);
    pcl::PCLPointCloud2 surfaces;
    pcl::toPCLPointCloud2(frame.cloud, surfaces);
    for (std::size_t index = 0; index < senders.size(); ++index) {
      const bool knows_truth = index % (filters.size() + 1) == filters.size();
      send(senders[index], knows_truth ? surfaces : cloud, pose);
    }
  }
  return bytesOf(senders, frames);
}

void
print(const std::vector<SentBytes>& sent, std::ostream& output)
{
  measuring::MarkdownTable table(
      {"law", "effort", "filter at the sensor", "voxels", "bytes", "less bytes %"});
  for (const SentBytes& one : sent)
    table.addRow({one.law,
                  one.effort,
                  one.filter,
                  measuring::formatted(one.voxels, 0),
                  measuring::formatted(one.bytes, 0),
                  measuring::formatted(one.less_percent, 1)});
  table.print(output);
}

void
addResults(const std::vector<SentBytes>& sent,
           unsigned int sensor,
           std::size_t frames,
           double resolution,
           report::ResultFile& results)
{
  for (const SentBytes& one : sent) {
    const report::Subject subject{"noise_bytes:" + one.law + " " + one.effort,
                                  std::to_string(sensor),
                                  one.filter,
                                  resolution};
    results.add(subject, "voxels", one.voxels, frames);
    results.add(subject, "bytes", one.bytes, frames);
    results.add(subject, "less_percent", one.less_percent, frames);
  }
}

} // namespace noise
} // namespace pcl_ext

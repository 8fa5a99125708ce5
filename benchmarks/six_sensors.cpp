#include "six_sensors.h"

#include <pcl_ext/nodes/central_node.h>

#include "machine.h"
#include "sensor_streams.h"

#include <cell/robot_cell.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace pcl_ext {
namespace benchmarks {

namespace {

using Clock = std::chrono::steady_clock;

constexpr float min_intensity = 2.0f; // voxels of fewer points are removed

/** \brief A sensor's clouds and the node beside it. */
struct Sensor {
  std::string name;
  WorldPose pose;
  std::vector<pcl::PCLPointCloud2> clouds;
  nodes::SensorNode node;
  NodeFigures figures;
};

Sensor
makeSensor(unsigned int number,
           const Workload& workload,
           const Variant& variant,
           std::size_t frames)
{
  const InputStream stream = openCellStream(number, frames);
  Sensor sensor{stream.clouds->name(),
                WorldPose(stream.clouds->sensorPose()),
                std::vector<pcl::PCLPointCloud2>(frames),
                nodes::SensorNode(sensorNodeSettings(stream, workload, variant)),
                NodeFigures()};
  for (std::size_t i = 0; i < frames; ++i)
    stream.clouds->read(i, sensor.clouds[i]);
  return sensor;
}

/** \brief Lets each node take what memory it needs, and notes it: of several that run at
 * once nobody could tell whose it is. */
void
growMemory(std::vector<Sensor>& sensors)
{
  std::vector<std::uint8_t> bytes;
  for (Sensor& sensor : sensors) {
    // Memory that others left to the heap would not show when it is taken again.
    malloc_trim(0);
    const double before = residentMegabytes();
    for (const pcl::PCLPointCloud2& cloud : sensor.clouds)
      sensor.node.encode(cloud, sensor.pose, bytes);
    sensor.node.requestIFrame();
    sensor.figures.megabytes = residentMegabytes() - before;
  }
}

/** \brief Encodes and sends at the cell's rate until the time is over. */
void
runSensor(Sensor& sensor,
          nodes::CentralNode& central,
          Clock::time_point start,
          double seconds)
{
  const double cpu_before = threadCpuSeconds();
  const auto period = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1.0 / cell::RobotCell::frame_rate));
  const auto ticks = static_cast<std::size_t>(seconds * cell::RobotCell::frame_rate);
  double cycle_sum_ms = 0.0;
  std::size_t bytes_sent = 0;
  std::vector<std::uint8_t> bytes;
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    std::this_thread::sleep_until(start + period * static_cast<Clock::rep>(tick));
    const auto begin = Clock::now();
    const nodes::Time stamp = nodes::systemTime();
    const auto status = sensor.node.encode(
        sensor.clouds[tick % sensor.clouds.size()], sensor.pose, bytes);
    const double cycle_ms =
        std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    cycle_sum_ms += cycle_ms;
    sensor.figures.max_cycle_ms = std::max(sensor.figures.max_cycle_ms, cycle_ms);
    bytes_sent += bytes.size();
    if (status.hasFrame())
      central.receive(sensor.name, bytes, stamp);
  }
  // A period for each frame, the last one's, too.
  std::this_thread::sleep_until(start + period * static_cast<Clock::rep>(ticks));
  const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
  sensor.figures.name = sensor.name;
  sensor.figures.frames_per_second = static_cast<double>(ticks) / elapsed;
  sensor.figures.megabits_per_second = 8e-6 * static_cast<double>(bytes_sent) / elapsed;
  sensor.figures.mean_cycle_ms = cycle_sum_ms / static_cast<double>(ticks);
  sensor.figures.cpu_percent = 100.0 * (threadCpuSeconds() - cpu_before) / elapsed;
}

/** \brief Cycle times of the frames that a CentralNode decoded lately, from its health.
 * \throws std::runtime_error if it did not decode every frame that was sent
 */
void
addHealth(const nodes::CentralNode& central, std::size_t sent, NodeFigures& figures)
{
  double cycle_sum_ms = 0.0;
  const auto health = central.health();
  for (const nodes::StreamHealth& stream : health) {
    if (stream.frames_decoded != sent)
      throw std::runtime_error(stream.name + ": " +
                               std::to_string(stream.frames_decoded) + " of " +
                               std::to_string(sent) + " frames were decoded");
    cycle_sum_ms += 1e3 * stream.rates.mean_cycle_seconds;
    figures.max_cycle_ms =
        std::max(figures.max_cycle_ms, 1e3 * stream.rates.max_cycle_seconds);
  }
  figures.mean_cycle_ms = cycle_sum_ms / static_cast<double>(health.size());
}

} // namespace

std::vector<NodeFigures>
runSixSensors(const Workload& workload,
              const Variant& variant,
              std::size_t frames,
              double seconds)
{
  std::vector<Sensor> sensors;
  for (unsigned int number = 1; number <= cell::RobotCell::sensor_count; ++number)
    sensors.push_back(makeSensor(number, workload, variant, frames));
  growMemory(sensors);
  malloc_trim(0);
  const double megabytes_before = residentMegabytes();

  nodes::CentralNodeSettings settings;
  settings.resolution = workload.resolution;
  nodes::CentralNode central(settings);
  for (const Sensor& sensor : sensors)
    central.addStream(sensor.name, min_intensity);
  const double cpu_before = processCpuSeconds();
  const auto start = Clock::now() + std::chrono::milliseconds(10);
  std::vector<std::thread> threads;
  for (Sensor& sensor : sensors)
    threads.emplace_back([&sensor, &central, start, seconds] {
      runSensor(sensor, central, start, seconds);
    });
  // The map's side: what all sensors show, at the rate at which they show it.
  io::VoxelFrame merged;
  const auto period = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(1.0 / cell::RobotCell::frame_rate));
  for (auto next = start; Clock::now() - start < std::chrono::duration<double>(seconds);
       next += period) {
    std::this_thread::sleep_until(next);
    central.merge(merged);
  }
  for (std::thread& thread : threads)
    thread.join();
  central.waitUntilDecoded();
  const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
  const double cpu_percent = 100.0 * (processCpuSeconds() - cpu_before) / elapsed;

  NodeFigures all;
  all.name = "central";
  all.cpu_percent = cpu_percent;
  all.megabytes = residentMegabytes() - megabytes_before;
  addHealth(
      central, static_cast<std::size_t>(seconds * cell::RobotCell::frame_rate), all);
  std::vector<NodeFigures> figures;
  for (const Sensor& sensor : sensors) {
    all.frames_per_second += sensor.figures.frames_per_second;
    all.megabits_per_second += sensor.figures.megabits_per_second;
    all.cpu_percent -= sensor.figures.cpu_percent;
    figures.push_back(sensor.figures);
  }
  figures.push_back(all);
  return figures;
}

} // namespace benchmarks
} // namespace pcl_ext

#include "sensors_at_once.h"

#include <pcl_ext/nodes/central_node.h>

#include "measuring/machine.h"
#include "simulator/robot_cell.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

namespace pcl_ext {
namespace report {

namespace {

using Clock = std::chrono::steady_clock;

/** \brief When all nodes begin, and how long they run. */
struct Schedule {
  Clock::time_point start;
  double seconds;

  /** \brief When a tick of a rate is due. */
  Clock::time_point
  due(std::size_t tick, double rate) const
  {
    return start + std::chrono::duration_cast<Clock::duration>(
                       std::chrono::duration<double>(static_cast<double>(tick) / rate));
  }

  std::size_t
  ticks(double rate) const
  {
    return std::max<std::size_t>(1, static_cast<std::size_t>(seconds * rate));
  }

  /** \brief Ticks from one sample of the rates to the next: a second, or the whole
   * run. */
  std::size_t
  ticksOfSample(double rate) const
  {
    return std::min(ticks(rate), static_cast<std::size_t>(rate));
  }
};

/** \brief Totals of a node since the start. */
struct Totals {
  double cpu_seconds = 0.0;
  double frames = 0.0;
  double bytes = 0.0;
};

/** \brief Samples the rates of a node. */
class RateSampler {
public:
  explicit RateSampler(const Totals& totals)
  : last_totals_(totals), last_time_(Clock::now())
  {}

  void
  sample(const Totals& totals, NodeFigures& figures)
  {
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_time_).count();
    figures.frames_per_second.add((totals.frames - last_totals_.frames) / seconds);
    figures.megabits_per_second.add(8e-6 * (totals.bytes - last_totals_.bytes) /
                                    seconds);
    figures.cpu_percent.add(100.0 * (totals.cpu_seconds - last_totals_.cpu_seconds) /
                            seconds);
    last_totals_ = totals;
    last_time_ = now;
  }

private:
  Totals last_totals_;
  Clock::time_point last_time_;
};

/** \brief The clouds of a sensor and its node. */
struct Sensor {
  std::string name;
  WorldPose pose;
  double frame_rate;
  std::vector<pcl::PCLPointCloud2> clouds;
  nodes::SensorNode node;
  NodeFigures figures;
};

/** \brief Totals that several threads add to. */
struct SharedTotals {
  std::atomic<std::int64_t> sensors_cpu_ns{0};
  std::atomic<std::uint64_t> frames{0}; ///< decoded
  std::atomic<std::uint64_t> bytes{0};  ///< of these
};

/** \brief Totals of the central node. Its processor time is that of the process without
 * the sensors' nodes. */
Totals
centralTotals(const SharedTotals& shared)
{
  return {measuring::processCpuSeconds() -
              1e-9 * static_cast<double>(shared.sensors_cpu_ns),
          static_cast<double>(shared.frames),
          static_cast<double>(shared.bytes)};
}

Sensor
makeSensor(const SensorAtWork& description)
{
  clouds::CloudSequence& clouds = *description.stream.clouds;
  Sensor sensor{clouds.name(),
                WorldPose(clouds.sensorPose()),
                description.frame_rate,
                std::vector<pcl::PCLPointCloud2>(clouds.size()),
                nodes::SensorNode(description.settings),
                NodeFigures()};
  for (std::size_t i = 0; i < clouds.size(); ++i)
    clouds.read(i, sensor.clouds[i]);
  return sensor;
}

/** \brief Measures the memory of each node, one after the other. */
void
growMemory(std::vector<Sensor>& sensors)
{
  std::vector<std::uint8_t> bytes;
  for (Sensor& sensor : sensors) {
    // Freed memory that stays in the heap would not be counted when it is used again.
    malloc_trim(0);
    const double before = measuring::residentMegabytes();
    for (const pcl::PCLPointCloud2& cloud : sensor.clouds)
      sensor.node.encode(cloud, sensor.pose, bytes);
    sensor.node.requestIFrame();
    sensor.figures.megabytes = measuring::residentMegabytes() - before;
  }
}

/** \brief Encodes and sends at the sensor's rate until the run ends. */
void
runSensor(Sensor& sensor,
          nodes::CentralNode& central,
          const Schedule& schedule,
          SharedTotals& shared)
{
  std::this_thread::sleep_until(schedule.start);
  const std::size_t ticks = schedule.ticks(sensor.frame_rate);
  const std::size_t ticks_of_sample = schedule.ticksOfSample(sensor.frame_rate);
  Totals totals{measuring::threadCpuSeconds()};
  RateSampler sampler(totals);
  std::vector<std::uint8_t> bytes;
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    const auto begin = Clock::now();
    const nodes::Time stamp = nodes::systemTime();
    sensor.node.encode(sensor.clouds[tick % sensor.clouds.size()], sensor.pose, bytes);
    sensor.figures.cycle_ms.add(
        std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    totals.frames += 1.0;
    totals.bytes += static_cast<double>(bytes.size());
    central.receive(sensor.name, bytes, stamp);
    const double cpu_seconds = measuring::threadCpuSeconds();
    shared.sensors_cpu_ns +=
        static_cast<std::int64_t>(1e9 * (cpu_seconds - totals.cpu_seconds));
    totals.cpu_seconds = cpu_seconds;
    std::this_thread::sleep_until(schedule.due(tick + 1, sensor.frame_rate));
    if ((tick + 1) % ticks_of_sample == 0)
      sampler.sample(totals, sensor.figures);
  }
  sensor.figures.name = sensor.name;
  sensor.figures.max_cycle_ms = sensor.figures.cycle_ms.largest();
}

/** \brief Merges the streams at the robot cell's rate until the run ends. */
void
mergeStreams(nodes::CentralNode& central,
             const Schedule& schedule,
             const SharedTotals& shared,
             RunAtOnce& run)
{
  std::this_thread::sleep_until(schedule.start);
  constexpr double rate = cell::RobotCell::frame_rate;
  RateSampler sampler(centralTotals(shared));
  io::VoxelFrame merged;
  for (std::size_t tick = 0; tick < schedule.ticks(rate); ++tick) {
    const auto begin = Clock::now();
    central.merge(merged);
    run.merge_ms.add(
        std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    // Not in the first half, when the first frames of some sensors may be missing.
    if (2 * tick >= schedule.ticks(rate))
      run.merged_voxels.add(static_cast<double>(merged.size()));
    std::this_thread::sleep_until(schedule.due(tick + 1, rate));
    if ((tick + 1) % schedule.ticksOfSample(rate) == 0)
      sampler.sample(centralTotals(shared), run.central);
  }
}

/** \brief Cycle times of the frames that a CentralNode decodes, from its health. */
void
addHealth(const nodes::CentralNode& central, NodeFigures& figures)
{
  for (const nodes::StreamHealth& stream : central.health()) {
    figures.cycle_ms.add(1e3 * stream.rates.mean_cycle_seconds);
    figures.max_cycle_ms =
        std::max(figures.max_cycle_ms, 1e3 * stream.rates.max_cycle_seconds);
  }
}

} // namespace

std::vector<SensorAtWork>
sixKinects(const Workload& workload, const Variant& variant, std::size_t frames)
{
  std::vector<SensorAtWork> sensors;
  for (unsigned int number = 1; number <= cell::RobotCell::sensor_count; ++number) {
    InputStream stream = measuring::openCellStream(number, frames);
    const nodes::SensorNodeSettings settings =
        measuring::sensorNodeSettings(stream, workload, variant);
    sensors.push_back({std::move(stream), settings, cell::RobotCell::frame_rate});
  }
  return sensors;
}

SensorAtWork
cellLidar(const Workload& workload, const Variant& variant, std::size_t frames)
{
  InputStream stream = measuring::openLidarStream(frames);
  nodes::SensorNodeSettings settings =
      measuring::sensorNodeSettings(stream, workload, variant);
  settings.law = IntensityLaw::Native;
  return {std::move(stream), settings, cell::RobotCell::lidar_rate};
}

RunAtOnce
runAtOnce(const std::vector<SensorAtWork>& descriptions,
          double seconds,
          float min_intensity)
{
  std::vector<Sensor> sensors;
  for (const SensorAtWork& description : descriptions)
    sensors.push_back(makeSensor(description));
  growMemory(sensors);
  malloc_trim(0);
  const double megabytes_before = measuring::residentMegabytes();

  RunAtOnce run;
  SharedTotals shared;
  nodes::CentralNodeSettings settings;
  settings.resolution = descriptions.front().settings.compression.resolution;
  nodes::CentralNode central(settings, [&shared](const nodes::ReceivedFrame& frame) {
    if (!frame.status.ok())
      return;
    ++shared.frames;
    shared.bytes += frame.statistics.bytes;
  });
  for (const Sensor& sensor : sensors)
    central.addStream(sensor.name, min_intensity);
  const Schedule schedule{Clock::now() + std::chrono::milliseconds(10), seconds};
  std::vector<std::thread> threads;
  for (Sensor& sensor : sensors)
    threads.emplace_back([&] { runSensor(sensor, central, schedule, shared); });
  mergeStreams(central, schedule, shared, run);
  for (std::thread& thread : threads)
    thread.join();
  central.waitUntilDecoded();

  run.central.name = "central";
  run.central.megabytes = measuring::residentMegabytes() - megabytes_before;
  addHealth(central, run.central);
  for (const Sensor& sensor : sensors)
    run.sensors.push_back(sensor.figures);
  return run;
}

} // namespace report
} // namespace pcl_ext

#include "sensors_at_once.h"

#include <pcl_ext/nodes/central_node.h>

#include "machine.h"
#include "sensor_streams.h"

#include <cell/robot_cell.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace pcl_ext {
namespace benchmarks {

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

  /** \brief Ticks from one look at the figures to the next: a second, if there is one. */
  std::size_t
  ticksOfLook(double rate) const
  {
    return std::min(ticks(rate), static_cast<std::size_t>(rate));
  }
};

/** \brief What a node did from one look at it to the next. */
struct Stretch {
  double seconds = 0.0;
  double cpu_seconds = 0.0;
  double frames = 0.0;
  double bytes = 0.0;
};

/** \brief Cuts a node's run into stretches. */
class Stretches {
public:
  using CpuClock = double (*)();

  explicit Stretches(CpuClock cpu_clock) : cpu_clock_(cpu_clock) { begin(); }

  void
  addFrame(std::size_t bytes)
  {
    current_.frames += 1.0;
    current_.bytes += static_cast<double>(bytes);
  }

  void
  look()
  {
    current_.seconds =
        std::chrono::duration<double>(Clock::now() - begin_time_).count();
    current_.cpu_seconds = cpu_clock_() - begin_cpu_;
    stretches_.push_back(current_);
    begin();
  }

  const std::vector<Stretch>&
  all() const
  {
    return stretches_;
  }

private:
  void
  begin()
  {
    current_ = Stretch();
    begin_time_ = Clock::now();
    begin_cpu_ = cpu_clock_();
  }

  CpuClock cpu_clock_;
  Stretch current_;
  Clock::time_point begin_time_;
  double begin_cpu_ = 0.0;
  std::vector<Stretch> stretches_;
};

/** \brief A sensor's clouds and the node beside it. */
struct Sensor {
  std::string name;
  WorldPose pose;
  double frame_rate;
  std::vector<pcl::PCLPointCloud2> clouds;
  nodes::SensorNode node;
  std::vector<Stretch> stretches;
  NodeFigures figures;
};

Sensor
makeSensor(const SensorAtWork& description)
{
  tools::CloudSequence& clouds = *description.stream.clouds;
  Sensor sensor{clouds.name(),
                WorldPose(clouds.sensorPose()),
                description.frame_rate,
                std::vector<pcl::PCLPointCloud2>(clouds.size()),
                nodes::SensorNode(description.settings),
                std::vector<Stretch>(),
                NodeFigures()};
  for (std::size_t i = 0; i < clouds.size(); ++i)
    clouds.read(i, sensor.clouds[i]);
  return sensor;
}

/** \brief Lets each node take what memory it needs, and notes it: of several that run at
 * once nobody could tell whose it is. */
void
growMemory(std::vector<Sensor>& sensors)
{
  std::vector<std::uint8_t> bytes;
  for (Sensor& sensor : sensors) {
    const double before = residentMegabytes();
    for (const pcl::PCLPointCloud2& cloud : sensor.clouds)
      sensor.node.encode(cloud, sensor.pose, bytes);
    sensor.node.requestIFrame();
    sensor.figures.megabytes = residentMegabytes() - before;
  }
}

/** \brief Encodes and sends at the sensor's rate until the time is over. */
void
runSensor(Sensor& sensor, nodes::CentralNode& central, const Schedule& schedule)
{
  std::this_thread::sleep_until(schedule.start);
  const std::size_t ticks = schedule.ticks(sensor.frame_rate);
  const std::size_t ticks_of_look = schedule.ticksOfLook(sensor.frame_rate);
  MeanAndDeviation cycle_ms;
  Stretches stretches(threadCpuSeconds);
  std::vector<std::uint8_t> bytes;
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    const auto begin = Clock::now();
    const nodes::Time stamp = nodes::systemTime();
    sensor.node.encode(sensor.clouds[tick % sensor.clouds.size()], sensor.pose, bytes);
    cycle_ms.add(
        std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    stretches.addFrame(bytes.size());
    central.receive(sensor.name, bytes, stamp);
    std::this_thread::sleep_until(schedule.due(tick + 1, sensor.frame_rate));
    if ((tick + 1) % ticks_of_look == 0)
      stretches.look();
  }
  sensor.stretches = stretches.all();
  sensor.figures.name = sensor.name;
  sensor.figures.cycle_ms = cycle_ms;
  sensor.figures.max_cycle_ms = cycle_ms.largest();
}

/** \brief The map's side: merges what all sensors show, until the time is over.
 * \return what the whole process did
 */
std::vector<Stretch>
mergeStreams(nodes::CentralNode& central, const Schedule& schedule, RunAtOnce& run)
{
  std::this_thread::sleep_until(schedule.start);
  constexpr double rate = cell::RobotCell::frame_rate;
  Stretches stretches(processCpuSeconds);
  io::VoxelFrame merged;
  for (std::size_t tick = 0; tick < schedule.ticks(rate); ++tick) {
    const auto begin = Clock::now();
    central.merge(merged);
    run.merge_ms.add(
        std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    // Not the first ones, before all sensors have shown something.
    if (2 * tick >= schedule.ticks(rate))
      run.merged_voxels.add(static_cast<double>(merged.size()));
    std::this_thread::sleep_until(schedule.due(tick + 1, rate));
    if ((tick + 1) % schedule.ticksOfLook(rate) == 0)
      stretches.look();
  }
  return stretches.all();
}

void
addStretch(const Stretch& stretch, NodeFigures& figures)
{
  figures.frames_per_second.add(stretch.frames / stretch.seconds);
  figures.megabits_per_second.add(8e-6 * stretch.bytes / stretch.seconds);
  figures.cpu_percent.add(100.0 * stretch.cpu_seconds / stretch.seconds);
}

/** \brief What of the process's doings is the central node's: all frames and bytes, and the
 * processor's time without that of the sensors' nodes. */
void
addCentralStretches(std::vector<Stretch> process,
                    const std::vector<Sensor>& sensors,
                    NodeFigures& figures)
{
  for (std::size_t i = 0; i < process.size(); ++i) {
    for (const Sensor& sensor : sensors) {
      const Stretch& stretch =
          sensor.stretches[std::min(i, sensor.stretches.size() - 1)];
      process[i].frames += stretch.frames;
      process[i].bytes += stretch.bytes;
      process[i].cpu_seconds -= stretch.cpu_seconds;
    }
    addStretch(process[i], figures);
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
    InputStream stream = openCellStream(number, frames);
    const nodes::SensorNodeSettings settings =
        sensorNodeSettings(stream, workload, variant);
    sensors.push_back({std::move(stream), settings, cell::RobotCell::frame_rate});
  }
  return sensors;
}

SensorAtWork
cellLidar(const Workload& workload, const Variant& variant, std::size_t frames)
{
  InputStream stream = openLidarStream(frames);
  nodes::SensorNodeSettings settings = sensorNodeSettings(stream, workload, variant);
  settings.law = nodes::IntensityLaw::Native;
  return {std::move(stream), settings, cell::RobotCell::lidar_rate};
}

RunAtOnce
runAtOnce(const std::vector<SensorAtWork>& descriptions, double seconds)
{
  std::vector<Sensor> sensors;
  for (const SensorAtWork& description : descriptions)
    sensors.push_back(makeSensor(description));
  growMemory(sensors);
  const double megabytes_before = residentMegabytes();

  RunAtOnce run;
  nodes::CentralNode central{nodes::CentralNodeSettings()};
  for (const Sensor& sensor : sensors)
    central.addStream(sensor.name);
  const Schedule schedule{Clock::now() + std::chrono::milliseconds(10), seconds};
  std::vector<std::thread> threads;
  for (Sensor& sensor : sensors)
    threads.emplace_back(
        [&sensor, &central, &schedule] { runSensor(sensor, central, schedule); });
  const std::vector<Stretch> process = mergeStreams(central, schedule, run);
  for (std::thread& thread : threads)
    thread.join();
  central.waitUntilDecoded();

  run.central.name = "central";
  run.central.megabytes = residentMegabytes() - megabytes_before;
  addHealth(central, run.central);
  addCentralStretches(process, sensors, run.central);
  for (Sensor& sensor : sensors) {
    for (const Stretch& stretch : sensor.stretches)
      addStretch(stretch, sensor.figures);
    run.sensors.push_back(sensor.figures);
  }
  return run;
}

} // namespace benchmarks
} // namespace pcl_ext

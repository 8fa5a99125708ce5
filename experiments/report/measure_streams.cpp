/** \file
 * Measures the streams of the simulated robot cell one by one, for the report that
 * experiments/report.sh makes: the paper's sections 3.1 and 3.2, and what moves.
 */
#include "depth_images.h"
#include "measuring/command_line.h"
#include "measuring/machine.h"
#include "measuring/result_file.h"
#include "measuring/workload.h"
#include "simulator/robot_cell.h"
#include "stream_results.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using pcl_ext::IntensityLaw;
using pcl_ext::cell::RobotCell;
using pcl_ext::measuring::InputStream;
using pcl_ext::measuring::ResultFile;
using pcl_ext::measuring::Subject;
using pcl_ext::measuring::Variant;
using pcl_ext::measuring::Workload;
using pcl_ext::report::StreamCoder;

struct StreamOptions {
  std::string file;
  std::string machine_file;  ///< empty: the machine is not described
  std::size_t frames = 1000; ///< of each sensor
};

/** \brief Frames of each of the 20 resolutions, and of each stream that moves. */
constexpr std::size_t most_frames_of_sweep = 100;

/** \brief Prints what is measured next. */
void
printProgress(const std::string& what)
{
  std::cerr << "measure_streams: " << what << '\n';
}

/** \brief A coder of each variant.
 * \param[in] subject of the results, less the coder
 */
std::vector<StreamCoder>
codersOf(const Subject& subject,
         const InputStream& stream,
         unsigned int i_frame_rate = Workload().i_frame_rate)
{
  Workload workload;
  workload.resolution = subject.resolution;
  workload.i_frame_rate = i_frame_rate;
  std::vector<StreamCoder> coders;
  for (const Variant& variant : pcl_ext::measuring::libraryVariants()) {
    StreamCoder coder{
        subject, pcl_ext::measuring::sensorNodeSettings(stream, workload, variant)};
    coder.subject.coder = variant.name;
    coders.push_back(coder);
  }
  return coders;
}

/** \brief Cropping, and compression at 4 and 2 cm, of one sensor. */
void
measureSensor(unsigned int number,
              const InputStream& stream,
              IntensityLaw law,
              double frame_rate,
              ResultFile& results)
{
  const std::string sensor = std::to_string(number);
  printProgress("sensor " + sensor);
  pcl_ext::report::measureCropping(
      stream, {"cropping", sensor, "SensorPreprocessor", 0.04}, results);
  std::vector<StreamCoder> coders;
  for (const double resolution : {0.04, 0.02})
    for (StreamCoder coder :
         codersOf({"compression", sensor, "", resolution}, stream)) {
      coder.settings.law = law;
      coders.push_back(coder);
    }
  pcl_ext::report::measureCoders(stream, frame_rate, coders, results);
}

void
measureSensors(const StreamOptions& options, ResultFile& results)
{
  for (unsigned int number = 1; number <= RobotCell::sensor_count; ++number)
    measureSensor(number,
                  pcl_ext::measuring::openCellStream(number, options.frames),
                  IntensityLaw::Count,
                  RobotCell::frame_rate,
                  results);
  measureSensor(RobotCell::lidar,
                pcl_ext::measuring::openLidarStream(options.frames),
                IntensityLaw::Native,
                RobotCell::lidar_rate,
                results);
}

/** \brief Sensor 1 with the two laws that depend on depth. */
void
measureLaws(const StreamOptions& options, ResultFile& results)
{
  printProgress("laws of intensity");
  const InputStream stream = pcl_ext::measuring::openCellStream(1, options.frames);
  std::vector<StreamCoder> coders;
  for (const IntensityLaw law : {IntensityLaw::Quadratic, IntensityLaw::Linear})
    for (StreamCoder coder : codersOf(
             {law == IntensityLaw::Quadratic ? "quadratic" : "linear", "1", "", 0.04},
             stream)) {
      coder.settings.law = law;
      coder.settings.sensor = pcl_ext::runtimeSensor(pcl_ext::KinectV2());
      coders.push_back(coder);
    }
  pcl_ext::report::measureCoders(stream, RobotCell::frame_rate, coders, results);
}

/** \brief Sensor 1 at 1 to 20 cm. */
void
measureResolutions(const StreamOptions& options, ResultFile& results)
{
  printProgress("resolutions");
  const InputStream stream = pcl_ext::measuring::openCellStream(
      1, std::min(options.frames, most_frames_of_sweep));
  std::vector<StreamCoder> coders;
  for (int centimetres = 1; centimetres <= 20; ++centimetres)
    for (const StreamCoder& coder :
         codersOf({"resolution", "1", "", centimetres / 100.0}, stream))
      coders.push_back(coder);
  pcl_ext::report::measureCoders(stream, RobotCell::frame_rate, coders, results);
}

/** \brief A stream in which something moves. */
struct MovingStream {
  const char* name;
  InputStream (*open)(std::size_t frames);
  IntensityLaw law = IntensityLaw::Count;
  double resolution = 0.04; ///< voxel edge, metres
  double frame_rate = RobotCell::frame_rate;
};

std::vector<MovingStream>
movingStreams()
{
  using namespace pcl_ext::measuring;
  const auto open_fixed = [](std::size_t frames) { return openCellStream(1, frames); };
  const auto open_lidar = [](std::size_t revolutions) {
    return openMobileLidarStream(revolutions);
  };
  const auto open_fast_lidar = [](std::size_t revolutions) {
    return openMobileLidarStream(revolutions, /* speed */ 10.0);
  };
  constexpr IntensityLaw native = IntensityLaw::Native;
  return {{"fixed camera", open_fixed},
          {"fixed camera and a person", openAisleStream},
          {"camera on a hand", openHandCameraStream},
          {"lidar at 1 m/s", open_lidar, native, 0.10, RobotCell::lidar_rate},
          {"lidar at 10 m/s", open_fast_lidar, native, 0.10, RobotCell::lidar_rate}};
}

/** \brief Sensors and people that move, with P-frames and with I-frames alone. */
void
measureMotion(const StreamOptions& options, ResultFile& results)
{
  for (const MovingStream& moving : movingStreams()) {
    printProgress(moving.name);
    const InputStream stream =
        moving.open(std::min(options.frames, most_frames_of_sweep));
    std::vector<StreamCoder> coders;
    for (const auto& [experiment, i_frame_rate] :
         {std::pair("motion", Workload().i_frame_rate),
          std::pair("motion_i_frames", 1u)})
      for (StreamCoder coder :
           codersOf({experiment, moving.name, "", moving.resolution},
                    stream,
                    i_frame_rate)) {
        coder.settings.law = moving.law;
        coders.push_back(coder);
      }
    pcl_ext::report::measureCoders(stream, moving.frame_rate, coders, results);
  }
}

void
measure(const StreamOptions& options)
{
  if (!options.machine_file.empty()) {
    std::ofstream machine(options.machine_file);
    pcl_ext::measuring::printMachine(machine);
    if (!machine)
      throw std::runtime_error("cannot write '" + options.machine_file + "'");
  }
  ResultFile results(options.file);
  results.add(
      {"streams_run", "", "all", 0.0}, "frames", static_cast<double>(options.frames));
  measureSensors(options, results);
  measureLaws(options, results);
  measureResolutions(options, results);
  measureMotion(options, results);
  printProgress("depth images");
  pcl_ext::report::measureDepthImages(
      pcl_ext::measuring::openCellStream(1, options.frames),
      RobotCell::frame_rate,
      results);
  results.close();
}

} // namespace

int
main(int argc, char** argv)
{
  StreamOptions options;
  CLI::App program("Measures the tables of experiments/report.sh.", "measure_streams");
  program.add_option("file", options.file, "CSV, for the results")->required();
  program.add_option(
      "--machine", options.machine_file, "file, for the description of the machine");
  program.add_option("--frames,-n", options.frames, "of each sensor of the robot cell")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  return pcl_ext::measuring::runProgram(
      program, argc, argv, [&options] { measure(options); });
}

/** \file
 * \brief Measures how well noise is told from surfaces in the voxels of the robot cell: by
 * the paper's laws, by the library's filter and by PCL's.
 */
#include "filter_times.h"
#include "measuring/markdown_table.h"
#include "methods.h"
#include "noise_figures.h"
#include "noise_options.h"
#include "shell_weights.h"
#include "simulator/labelled_lidar.h"
#include "stream_bytes.h"

#include <result_file.h>

#include <cstdint>
#include <exception>
#include <iostream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::noise;

/** \brief Prints what is measured and, where that is wanted, adds it to a file. */
class Measurement {
public:
  explicit Measurement(const NoiseOptions& options) : options_(options)
  {
    if (!options.results_file.empty())
      results_.emplace(options.results_file);
  }

  void
  run()
  {
    std::cout << options_.frames << " frames, seed " << options_.seed << ", "
              << 100.0 * options_.resolution << " cm\n\n";
    for (const unsigned int sensor : options_.sensors)
      measureSensor(sensor);
    if (options_.wants(NoisePart::Fused))
      measureFused();
    if (results_)
      results_->close();
  }

private:
  void
  measureSensor(unsigned int sensor)
  {
    const std::string name = std::to_string(sensor);
    if (options_.wants(NoisePart::Laws)) {
      std::cout << "## Sensor " << name << "\n\n";
      if (sensor == cell::RobotCell::lidar)
        judgeStream(LabelledLidar(options_.seed, options_.resolution),
                    "noise",
                    name,
                    lidarMethods());
      else
        judgeStream(cameraStream(sensor), "noise", name, cameraMethods());
    }
    if (options_.wants(NoisePart::Peers)) {
      std::cout << "## PCL's filters, sensor " << name << "\n\n";
      judgeStream(
          cameraStream(sensor), "noise_peers", name, peerMethods(options_.resolution));
    }
    if (options_.wants(NoisePart::Time))
      measureTimes(sensor);
    if (options_.wants(NoisePart::Bytes))
      measureBytes(sensor);
    if (options_.wants(NoisePart::Weights))
      printShellWeights(
          options_.seed, sensor, options_.resolution, options_.frames, std::cout);
  }

  void
  measureFused()
  {
    std::cout << "## All six cameras, merged\n\n";
    FusedStream stream(options_.seed, options_.resolution);
    judgeStream(stream, "noise", "merged", mergedMethods(stream), false);
  }

  void
  measureTimes(unsigned int sensor)
  {
    const TimedFilters timed =
        measureFilterTimes(options_.seed, sensor, options_.frames, options_.resolution);
    std::cout << "## Time, sensor " << sensor << ", "
              << measuring::formatted(timed.voxels, 0)
              << " voxels, processor milliseconds a frame\n\n";
    print(timed, std::cout);
    if (results_)
      addResults(timed, *results_);
  }

  void
  measureBytes(unsigned int sensor)
  {
    const std::vector<SentBytes> sent =
        measureStreamBytes(options_.seed, sensor, options_.frames, options_.resolution);
    std::cout << "## Bytes of the stream, sensor " << sensor
              << ", averages per frame\n\n";
    print(sent, std::cout);
    if (results_)
      addResults(sent, sensor, options_.frames, options_.resolution, *results_);
  }

  LabelledStream
  cameraStream(unsigned int sensor) const
  {
    return LabelledStream(options_.seed, sensor, options_.resolution);
  }

  template <typename StreamT>
  void
  judgeStream(StreamT&& stream,
              const std::string& experiment,
              const std::string& sensor,
              std::vector<Method> methods,
              bool has_depths = true)
  {
    LabelledFrame frame;
    for (std::uint32_t i = 0; i < options_.frames; ++i) {
      stream.read(i, frame);
      judge(frame, methods);
    }
    const std::vector<MethodFigures> figures = figuresOf(std::move(methods));
    const Measured measured{sensor, options_.resolution, options_.frames, has_depths};
    print(measured, figures, std::cout);
    if (results_)
      addResults(experiment, measured, figures, *results_);
  }

  NoiseOptions options_;
  std::optional<report::ResultFile> results_;
};

} // namespace

int
main(int argc, char** argv)
{
  try {
    if (const auto options = parseNoiseOptions(argc, argv))
      Measurement(*options).run();
    return 0;
  }
  catch (const std::exception& error) {
    std::cerr << "measure_noise: " << error.what() << '\n';
    return 1;
  }
}

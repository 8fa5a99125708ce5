#include "temporal_results.h"

#include "filtered_stream.h"
#include "measuring/result_file.h"
#include "simulator/labelled_lidar.h"
#include "temporal_samples.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace noise {

namespace {

constexpr std::int64_t usual_first_judged = 20;

std::int64_t
firstJudged(std::uint32_t frames)
{
  return std::min(usual_first_judged, static_cast<std::int64_t>(frames) / 2);
}

std::vector<FilteredStream>
filteredStreams(Law law, std::uint32_t frames)
{
  std::vector<FilteredStream> streams;
  for (const auto& [name, removes_outliers, is_temporal] :
       {std::tuple("none", false, false),
        std::tuple("outliers", true, false),
        std::tuple("temporal", false, true),
        std::tuple("both", true, true)})
    streams.emplace_back(
        name,
        [law, outliers = removes_outliers, temporal = is_temporal] {
          return FilterChain(outliers, temporal, law);
        },
        firstJudged(frames));
  return streams;
}

/** \brief Adds the results of one stream and filter. */
class TemporalResults {
public:
  TemporalResults(measuring::Subject subject, measuring::ResultFile& results)
  : subject_(std::move(subject)), results_(results)
  {}

  /** \brief Adds everything.
   * \param[in] filtered the stream
   * \param[in] unfiltered the same without a filter
   */
  void
  add(const FilteredStream& filtered, const FilteredStream& unfiltered)
  {
    results_.add(subject_, "voxels", filtered.voxels);
    for (std::size_t i = 0; i < filtered.coded.size(); ++i)
      add(filtered.coded[i], unfiltered.coded[i]);
    const ShownJudge& judge = filtered.judge;
    add("surface", judge.surface_percent);
    add("person", judge.person_percent);
    const std::size_t frames = filtered.voxels.count();
    add("new_percent", judge.new_surface.percent(), frames);
    add("new_voxels", judge.new_surface.all, frames);
    add("new_later_percent", judge.new_surface_later.percent(), frames);
    const std::size_t judged = judge.surface_percent.count();
    add("noise_percent", judge.noise.percent(), judged);
    add("ghosts_percent", judge.ghosts.percent(), judged);
    add("ghosts", judge.ghosts.counted / static_cast<double>(judged), judged);
    add("left_behind", judge.left_behind.counted / static_cast<double>(judged), judged);
    add("intensity_error_ratio", judge.intensity.ratio(), frames);
    results_.add(subject_, "filter_ms", filtered.filter_ms);
    results_.add(subject_, "decode_ms", filtered.decode_ms);
  }

private:
  void
  add(const std::string& quantity, double value, std::size_t frames)
  {
    if (!std::isnan(value))
      results_.add(subject_, quantity, value, frames);
  }

  /** \brief Mean and least of frames. */
  void
  add(const std::string& what, const measuring::Samples& percent)
  {
    if (percent.count() == 0)
      return;
    results_.add(subject_, what + "_percent", percent);
    add(what + "_worst_percent", percent.smallest(), percent.count());
  }

  void
  add(const CodedBytes& coded, const CodedBytes& unfiltered)
  {
    const auto name = [&](const std::string& quantity) {
      return coded.name + " " + quantity;
    };
    results_.add(subject_, name("bytes"), coded.all);
    results_.add(subject_, name("i_frame_bytes"), coded.i_frames);
    results_.add(subject_, name("p_frame_bytes"), coded.p_frames);
    const std::size_t frames = coded.all.count();
    add(name("of_unfiltered_percent"),
        100.0 * coded.all.sum() / unfiltered.all.sum(),
        frames);
    add(name("i_frames_percent"),
        100.0 * coded.i_frames.sum() / coded.all.sum(),
        frames);
  }

  measuring::Subject subject_;
  measuring::ResultFile& results_;
};

/** \brief What is measured of all streams. */
struct Measured {
  std::string sensor;
  double resolution;
  std::vector<Law> laws; ///< the first one has the samples
  std::uint32_t frames;
};

template <typename StreamT>
void
measureStream(const Measured& measured,
              StreamT&& stream,
              const std::string& samples_folder,
              measuring::ResultFile& results)
{
  const auto& [sensor, resolution, laws, frames] = measured;
  std::optional<TemporalSamples> samples;
  if (!samples_folder.empty())
    samples.emplace(samples_folder, firstJudged(frames));
  SurfaceHistory truth;
  std::vector<std::vector<FilteredStream>> streams;
  for (const Law law : laws)
    streams.push_back(filteredStreams(law, frames));
  LabelledFrame frame;
  for (std::uint32_t i = 0; i < frames; ++i) {
    stream.read(i, frame);
    const TrueView view(stream.pose(i), stream.surfaces(i));
    const Eigen::Vector3d position = view.sensorPosition();
    truth.add(frame.of(laws.front()), frame.truth, view);
    for (std::size_t law = 0; law < laws.size(); ++law)
      for (FilteredStream& filtered : streams[law])
        filtered.add(truth, frame.of(laws[law]), position);
    if (samples)
      samples->add(truth, frame, streams.front());
  }
  if (samples)
    samples->close();
  for (std::size_t law = 0; law < laws.size(); ++law)
    for (const FilteredStream& filtered : streams[law])
      TemporalResults(
          {"temporal:" + nameOf(laws[law]), sensor, filtered.name, resolution}, results)
          .add(filtered, streams[law].front());
}

} // namespace

void
measureTemporalFilter(std::uint32_t seed,
                      unsigned int sensor,
                      std::uint32_t frames,
                      std::optional<double> resolution,
                      const std::string& samples,
                      measuring::ResultFile& results)
{
  const double edge = resolution.value_or(0.04);
  const std::string name = std::to_string(sensor);
  if (sensor == cell::RobotCell::lidar) {
    measureStream({name, edge, {Law::Native}, frames},
                  LabelledLidar(seed, edge),
                  samples,
                  results);
    return;
  }
  if (sensor == hand_camera) {
    measureStream({"hand", edge, {Law::Count}, frames},
                  LabelledStream(seed, 1, edge, cell::handCamera),
                  samples,
                  results);
    return;
  }
  measureStream({name, edge, {Law::Count, Law::Quadratic}, frames},
                LabelledStream(seed, sensor, edge),
                samples,
                results);
  if (!resolution)
    measureStream({name, 0.02, {Law::Count}, frames},
                  LabelledStream(seed, sensor, 0.02),
                  {},
                  results);
}

} // namespace noise
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "advice/stream_trials.h"

#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "advice/surface_closure.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "measuring/samples.h"
#include "rate/rate_estimate.h"
#include "streams/stream_encoder.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace pcl_ext::tools {

namespace {

constexpr std::size_t usual_edges = 7;
constexpr std::size_t most_edges = 10;

/** \brief Some frames with one setting. */
struct EncodedFrames {
  double frame_bytes = 0.0;   // mean, with the share of I-frames that is set
  double i_frame_bytes = 0.0; // of the largest
  double p_frame_bytes = 0.0;
  double ms = 0.0; // median
  EncodedSums sums;
  IntensityLaw law = IntensityLaw::None;
  std::string why_empty;
};

/** \brief Encodes at least two clouds, if there are, and more until the time is over or
 * the next I-frame is due. */
EncodedFrames
encodeSome(const EncodingOptions& options, const HeldClouds& stream, double seconds)
{
  const auto rate =
      static_cast<std::size_t>(io::framesOfIFrame(options.codec(), stream.period));
  const std::size_t most =
      rate == 1 ? stream.clouds.size() : std::min(stream.clouds.size(), rate);
  StreamEncoder encoder(options, stream.name);
  encoder.chooseLaw(stream.clouds);
  measuring::Samples p_frames;
  measuring::Samples ms;
  double first_bytes = 0.0;
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < most && (i < 2 || ms.sum() < 1e3 * seconds); ++i) {
    const std::string source = stream.name + ", cloud " + std::to_string(i);
    ms.add(measuring::wallTimeOf(
        [&] { encoder.encode(stream.clouds[i], source, bytes); }));
    if (i == 0)
      first_bytes = static_cast<double>(bytes.size());
    else
      p_frames.add(static_cast<double>(bytes.size()));
  }
  const double others = p_frames.count() == 0 ? first_bytes : p_frames.mean();
  // Without P-frames all that were encoded have the same weight.
  const auto weight = static_cast<double>(rate == 1 ? ms.count() : rate);
  const double largest = std::max(first_bytes, p_frames.largest());
  return {(first_bytes + (weight - 1.0) * others) / weight,
          rate == 1 ? largest : first_bytes,
          p_frames.count() == 0 ? first_bytes : p_frames.largest(),
          ms.median(),
          encoder.sums(),
          encoder.law(),
          encoder.whyNothingWasEncoded()};
}

/** \brief The points of a cloud that are encoded. */
Points
pointsOf(const pcl::PCLPointCloud2& cloud,
         const EncodingOptions& options,
         const std::string& stream)
{
  Eigen::Isometry3d pose(options.poseOf(stream));
  SensorPreprocessor<NoIntensity> preprocessor(NoIntensity(1.0));
  Points points;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  // The second time near the origin, where floats tell millimetres.
  for (int pass = 0; pass < 2; ++pass) {
    pose.pretranslate(-shift);
    preprocessor.setSensorPose(pose);
    if (const auto& box = options.cropBox())
      preprocessor.setCropBox(Eigen::Vector3d(box->min.data()) - shift,
                              Eigen::Vector3d(box->max.data()) - shift);
    if (!preprocessor.process(cloud, points).ok() || points.empty())
      return {};
    shift = points.front().getVector3fMap().cast<double>();
  }
  return points;
}

/** \brief Leaves one of points that coincide: missing points all are at the sensor, and
 * no surface. */
void
removeRepeated(Points& points)
{
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto place = [&points](std::size_t i) {
    return std::make_tuple(points[i].x, points[i].y, points[i].z);
  };
  std::sort(order.begin(), order.end(), [&place](std::size_t a, std::size_t b) {
    return std::make_pair(place(a), a) < std::make_pair(place(b), b);
  });
  std::vector<bool> is_repeated(points.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i)
    is_repeated[order[i]] = place(order[i]) == place(order[i - 1]);
  Points others;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!is_repeated[i])
      others.push_back(points[i]);
  points.swap(others);
}

/** \brief The points of up to three clouds with points. */
std::vector<Points>
sampleClouds(const EncodingOptions& options, const HeldClouds& stream)
{
  constexpr std::size_t most = 3;
  std::vector<Points> samples;
  const std::size_t step = std::max<std::size_t>(stream.clouds.size() / most, 1);
  for (std::size_t i = 0; i < stream.clouds.size() && samples.size() < most;
       i += step) {
    Points points = pointsOf(stream.clouds[i], options, stream.name);
    removeRepeated(points);
    if (!points.empty())
      samples.push_back(std::move(points));
  }
  return samples;
}

/** \brief The place in roundEdges() of the edge at which points begin to share voxels. */
std::size_t
placeOfSpacing(const std::vector<double>& edges, const Points& points)
{
  constexpr double sharing = 1.1; // points in a voxel
  std::size_t place = 0;
  while (place + 2 < edges.size() &&
         sharing * static_cast<double>(occupiedVoxels(points, edges[place])) >
             static_cast<double>(points.size()))
    place += 2;
  return place;
}

/** \brief Number of round edges from one to that of ten times its length. */
constexpr std::size_t edges_to_tenfold = 8;

constexpr std::size_t largest_usual = 2 * (usual_edges - 1);

/** \brief Edges to try, at even places; at odd ones those between them. Further ones are
 * only to judge surfaces. */
std::vector<double>
edgesFor(const TrialOptions& options, const Points& points)
{
  std::vector<double> edges = roundEdges();
  const auto spacing =
      options.encoding.codec().keepsPoints()
          ? edges.begin()
          : edges.begin() + static_cast<std::ptrdiff_t>(placeOfSpacing(edges, points));
  edges.erase(edges.begin(), spacing);
  std::size_t last = 2 * (most_edges - 1) + edges_to_tenfold;
  if (options.edge) {
    const auto place = std::lower_bound(edges.begin(), edges.end(), *options.edge);
    last = std::max(static_cast<std::size_t>(place - edges.begin()), largest_usual) +
           edges_to_tenfold;
    if (place == edges.end() || *place != *options.edge) {
      edges.insert(place, *options.edge);
      ++last;
    }
  }
  edges.resize(std::min(edges.size(), last + 1));
  return edges;
}

/** \brief The share that --remove-outliers would remove, with a law by which noise is
 * found. */
std::optional<double>
noiseOf(EncodingOptions options,
        const HeldClouds& stream,
        IntensityLaw law,
        double seconds)
{
  const bool tells_density = law != IntensityLaw::Native && law != IntensityLaw::None;
  options.removeOutliersBy(tells_density ? law : IntensityLaw::Count);
  const EncodedSums sums = encodeSome(options, stream, seconds).sums;
  if (sums.judged_points > 0)
    return static_cast<double>(sums.point_outliers) /
           static_cast<double>(sums.judged_points);
  const std::size_t voxels = sums.outliers + sums.occupiedVoxels();
  if (voxels == 0 || !VoxelOutlierRemoval::isMadeFor(options.codec().resolution))
    return std::nullopt;
  return static_cast<double>(sums.outliers) / static_cast<double>(voxels);
}

/** \brief Tries one edge with all efforts. */
class EdgeTrials {
public:
  EdgeTrials(const TrialOptions& options,
             const HeldClouds& stream,
             double seconds,
             const std::function<void()>& advance)
  : options_(options)
  , encoding_(options.encoding)
  , stream_(stream)
  , seconds_(seconds)
  , advance_(advance)
  {}

  /** \brief Adds an edge to what was tried, unless nothing can be encoded with it. */
  void
  add(double edge, double holes, StreamTrials& trials)
  {
    EdgeTrial trial;
    trial.edge = edge;
    trial.holes = holes;
    encoding_.codec().resolution = edge;
    bool is_encoded = false;
    for (const auto& [effort, name] : io::efforts) {
      if (isInterrupted() || (options_.effort && *options_.effort != effort))
        continue;
      encoding_.codec().effort = effort;
      is_encoded |= addEffort(static_cast<std::size_t>(effort), trial, trials);
      advance_();
    }
    if (!is_encoded || isInterrupted())
      return;
    try {
      trial.noise = noiseOf(encoding_, stream_, trials.law, seconds_);
    }
    catch (const std::runtime_error&) { // this law is not for these settings
    }
    advance_();
    const auto place =
        std::find_if(trials.edges.begin(),
                     trials.edges.end(),
                     [edge](const EdgeTrial& other) { return other.edge > edge; });
    trials.edges.insert(place, trial);
  }

private:
  /** \return whether something was encoded */
  bool
  addEffort(std::size_t effort, EdgeTrial& trial, StreamTrials& trials)
  {
    try {
      const EncodedFrames frames = encodeSome(encoding_, stream_, seconds_);
      trials.law = frames.law;
      if (frames.sums.encoded_points == 0) {
        trials.fault =
            frames.why_empty.empty() ? "its clouds have no points" : frames.why_empty;
        return false;
      }
      trial.efforts[effort] =
          EffortTrial{8e-3 * frames.frame_bytes / trials.limits.period,
                      frames.ms,
                      1e-3 * io::leastRate(encoding_.codec(),
                                           trials.limits.period,
                                           frames.i_frame_bytes,
                                           frames.p_frame_bytes)};
      trial.points_outside_grid = describePointsOutsideGrid(frames.sums);
      trials.points = static_cast<double>(frames.sums.encoded_points) /
                      static_cast<double>(frames.sums.frames);
      const EncodedSums& sums = frames.sums;
      const std::size_t occupied = sums.occupiedVoxels();
      trial.points_a_voxel =
          occupied == 0
              ? 0.0
              : static_cast<double>(sums.encoded_points - sums.points_in_order) /
                    static_cast<double>(occupied);
      return true;
    }
    catch (const UsageError& error) {
      const bool judges_voxels = VoxelOutlierRemoval::isMadeFor(trial.edge);
      if (options_.edge || !encoding_.removesOutliers() || judges_voxels)
        throw;
      trials.fault = error.what(); // outliers are not removed at this edge
      return false;
    }
    catch (const std::runtime_error& error) { // more voxels than a reader takes
      trials.fault = error.what();
      return false;
    }
  }

  const TrialOptions& options_;
  EncodingOptions encoding_;
  const HeldClouds& stream_;
  double seconds_;
  const std::function<void()>& advance_;
};

/** \brief Tries edges until they tell which one to choose. */
void
tryEdges(const TrialOptions& options,
         const std::vector<double>& edges,
         const SurfaceClosure& closure,
         EdgeTrials& tried,
         StreamTrials& trials)
{
  const auto add = [&](std::size_t place) {
    // What a surface is is decided at ten times the largest usual edge, or ten times this
    // one if it is larger.
    const std::size_t closed =
        options.edge ? edges.size() : std::max(place, largest_usual) + edges_to_tenfold;
    const double holes = closure.holesAt(place, std::min(closed, edges.size() - 1));
    tried.add(edges[place], holes, trials);
    if (!trials.edges.empty())
      trials.choice = choose(trials.edges, trials.limits);
  };
  const auto keepsLimits = [&trials] {
    return !trials.edges.empty() && trials.choice.fault == ChoiceFault::None;
  };
  const auto placeOf = [&edges](double edge) {
    return static_cast<std::size_t>(std::lower_bound(edges.begin(), edges.end(), edge) -
                                    edges.begin());
  };
  if (options.edge)
    return add(placeOf(*options.edge));
  for (std::size_t i = 0; i < most_edges && 2 * i < edges.size(); ++i)
    if (!isInterrupted() && (i < usual_edges || !keepsLimits()))
      add(2 * i);
  if (!isInterrupted() && keepsLimits())
    if (const std::size_t place = placeOf(trials.edges[trials.choice.edge].edge);
        place > 0)
      add(place - 1);
}

} // namespace

StreamTrials
tryStream(const TrialOptions& options,
          const HeldClouds& stream,
          std::size_t streams,
          const std::function<void()>& advance)
{
  constexpr double seconds = 20.0;
  StreamTrials trials;
  trials.limits.period = stream.period > 0.0 ? stream.period : options.usual_period;
  if (options.max_rate)
    trials.limits.kilobits = *options.max_rate / 1e3;
  if (options.edge || options.encoding.codec().keepsPoints())
    trials.limits.most_holes = 1.0;
  const std::vector<Points> samples = sampleClouds(options.encoding, stream);
  // Without points there is still a reason to be told.
  const std::vector<double> edges =
      samples.empty() ? std::vector<double>{options.encoding.codec().resolution}
                      : edgesFor(options, samples.front());
  SurfaceClosure closure(edges);
  for (const Points& points : samples)
    closure.add(points);
  EdgeTrials tried(
      options,
      stream,
      seconds / static_cast<double>(streams * usual_edges * (io::efforts.size() + 1)),
      advance);
  tryEdges(options, edges, closure, tried, trials);
  return trials;
}

} // namespace pcl_ext::tools

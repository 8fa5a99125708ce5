// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/i_frame_requests.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/merging_centre.h>

#include "live/live_output.h"
#include "nodes/merged_frame_encoder.h"
#include "options/decoding_options.h"
#include "site/centre_map.h"
#include "site/frame_taker.h"

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext::tools {

struct CentreOptions {
  std::string name; ///< of the merged stream; empty: it is not published
  std::optional<double> resolution; ///< metres; none: that of the first frame
  io::StreamSettings stream;        ///< effort and I-frames of the merged stream
  nodes::MergeScheduleSettings schedule;
  bool is_replay = false; ///< frames come as fast as they are taken
  DecodingOptions decoding;
  CentreMapOptions map;

  /** \brief True if streams have to be decoded. */
  bool
  isOn() const
  {
    return !name.empty() || !map.path.empty();
  }
};

/** \brief Decodes the streams of a site, merges them on a common grid, and passes the
 * merged stream on; feeds an OctoMap. */
class Centre : public FrameTaker {
public:
  using RequestIFrame = std::function<void(const std::string& stream)>;

  /** \param[in] options must outlive this
   * \param[in] request_i_frame called by any thread
   * \param[in] console must outlive this
   * \throws UsageError if a setting is outside its range
   */
  Centre(const CentreOptions& options, RequestIFrame request_i_frame, Console& console);

  /** \brief Adds where the merged stream goes; it must outlive this. */
  void
  addOutput(LiveOutput& output);

  /** \brief Makes the next merged frame an I-frame, but not two in a row. Called by any
   * thread. */
  void
  requestIFrame()
  {
    requests_.add();
  }

  void
  take(const link::LinkFrame& frame) override;

  void
  work() override;

  void
  finish() override;

  bool
  hasLeftOut() const override;

  /** \brief How many merged frames a stream was missing in, and why. */
  struct Missing {
    std::size_t undecodable = 0; ///< its last frame could not be decoded
    std::size_t dropped = 0;     ///< its voxels were dropped to keep the memory limit
    std::size_t old = 0;         ///< its last frame was too old
  };

  /** \brief By the names of the streams; none is missing before its first frame. */
  const std::map<std::string, Missing>&
  missing() const
  {
    return missing_;
  }

  /** \brief Edge of the voxels of merged grid and map, metres; 0: no frame has come. */
  double
  mergedResolution() const;

  /** \brief Whether a faster effort helps: of the merged stream, or of one that
   * arrives. */
  bool
  hasSlowEffort() const
  {
    return has_slow_effort_ ||
           (!outputs_.empty() && options_.stream.effort != io::Effort::Fast);
  }

  /** \brief Health of the streams. Called by any thread. */
  std::vector<nodes::StreamHealth>
  health() const;

  /** \brief Merged frames that were made, and that were left out. Called by any thread.
   */
  nodes::MergeCounts
  mergeCounts() const;

  /** \brief Updates of the map; none if there is no map. Called by any thread. */
  std::optional<nodes::MapCounts>
  mapCounts() const;

private:
  /** \brief What there is for one edge of voxels. */
  struct Grid {
    Grid(Centre& centre, double merged_resolution);

    const double resolution;
    nodes::MergedFrameEncoder encoder;
    std::optional<CentreMap> map;
    nodes::MergingCentre centre;
  };

  struct Output {
    LiveOutput* output;
    std::size_t stream;
  };

  /** \return whether it can be decoded; if not, that is told */
  bool
  addStream(const link::LinkFrame& frame);

  void
  setOutlierRemoval(const link::LinkFrame& frame);

  /** \brief Takes the pose of the sensor from an I-frame. */
  void
  applyMetadata(const link::LinkFrame& frame);

  void
  makeGrid(double resolution);

  nodes::MergingCentreSettings
  settingsOf(double resolution) const;

  void
  publish(const nodes::MergedFrame& merged);

  void
  countMissing(const nodes::MergedFrame& merged);

  /** \brief Tells which streams have another clock than the others, and that the clock of
   * merged times is another one. */
  void
  tellOfClocks(const nodes::MergedFrame& merged);

  const CentreOptions& options_;
  const RequestIFrame request_i_frame_;
  Console& console_;
  mutable std::mutex grid_mutex_; // guards the pointer, which other threads read
  std::unique_ptr<Grid> grid_;    // null until the first frame, if that tells its edge
  io::IFrameRequests requests_;
  std::map<std::string, bool> streams_; // and whether they are decoded
  MetadataChanges metadata_changes_;
  std::vector<Output> outputs_;
  std::map<std::string, Missing> missing_;
  std::set<std::string> merged_streams_;    // that a merged frame had
  std::set<std::string> repeating_streams_; // have repeated times, which was told
  std::set<std::string> other_clocks_;      // streams of them, which was told
  std::optional<nodes::Time> merged_time_;  // of the last merged frame
  bool has_slow_effort_ = false;            // one of the streams that arrive
  nodes::Time kept_{0};                     // of the latest frame of a replay
};

} // namespace pcl_ext::tools

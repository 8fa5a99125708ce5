// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/health_metrics.h>
#include <pcl_ext/nodes/impl/merged_map.h>

#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "console/throw_unless_ok.h"
#include "inputs/stream_metadata.h"
#include "options/text_values.h"
#include "outputs/output_path.h"
#include "recording/files.h"
#include "streams/stream_decoder.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <future>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

namespace pcl_ext::tools {

/** \brief An OctoMap that is fed with the streams of a site. */
struct CentreMapOptions {
  std::string path;         ///< of the .ot file; empty: no map
  bool may_replace = false; ///< a file that is there
  /** \brief Intensity that counts as one hit, in the unit of the streams; 0: each voxel
   * does; none: 0 for streams whose law is native, else 4. */
  std::optional<double> full_intensity;
  bool waits = false; ///< for each update, as a replay can
};

/** \brief Feeds the map: at the end of each second of the clouds' time, from the first
 * update() on, with the latest frames. That is done by a thread of its own, as it may
 * take longer than from one merged frame to the next; what it has no time for in the
 * second that follows is left out, and counted. */
class CentreMap {
public:
  /** \param[in] resolution metres
   * \param[in] console must outlive this
   * \throws UsageError if the map cannot be written
   */
  CentreMap(const CentreMapOptions& options, double resolution, Console& console)
  : options_(options)
  , unfinished_(options.path + unfinished_suffix)
  , console_(console)
  , map_(resolution)
  {
    const std::string fault = nodes::detail::MergedMap::faultOf("--map", options.path);
    if (!fault.empty())
      throw UsageError(fault);
  }

  /** \brief Adds a stream, or has other metadata of it from a time of the clouds on; rays
   * are taken from the pose that they tell, and a hit is what suits their law. */
  void
  setMetadata(const std::string& name,
              const StreamMetadata& metadata,
              nodes::Time since)
  {
    const auto position = positionOf(metadata);
    const auto [sensor, is_new] =
        sensors_.try_emplace(name, Sensor{since, position, position});
    if (!is_new)
      sensor->second = {since, position, sensor->second.position};
    if (!position && !has_told_of_pose_) {
      console_.remark(name +
                      ": no pose of its sensor is known, so that the map gets no free "
                      "space from this stream, nor from others without one: --pose of "
                      "encode and send tells it");
      has_told_of_pose_ = true;
    }
    constexpr double points_of_a_hit = 4.0;
    sensor->second.full_intensity = options_.full_intensity.value_or(
        lawOf(metadata) == IntensityLaw::Native ? 0.0 : points_of_a_hit);
  }

  /** \brief Inserts the latest frames, if a second has ended and no others are being
   * inserted, for which a replay waits. Writes the map once a minute.
   * \param[in] node must outlive this
   * \param[in] time of the clouds
   * \throws std::runtime_error if it could not be written
   */
  void
  update(const nodes::CentralNode& node, nodes::Time time)
  {
    if (isToldToEnd())
      return;
    if (!begin_)
      begin_ = time;
    if (const auto second = std::chrono::floor<std::chrono::seconds>(time - *begin_);
        second != second_) {
      left_out_ += is_due_ ? 1 : 0;
      is_due_ = true;
      second_ = second;
    }
    if (!is_due_)
      return;
    if (update_.valid()) {
      if (update_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
        return;
      update_.get();
    }
    is_due_ = false;
    beginUpdate(node);
    if (options_.waits)
      waitForUpdate();
  }

  /** \brief Inserts the last frames, unless that takes long or the program is
   * interrupted, and writes the map: not an empty one, and that of a part of a replay
   * beside an earlier one, with ".unfinished" added to its name.
   * \throws std::runtime_error
   */
  void
  finish(const nodes::CentralNode& node)
  {
    constexpr std::chrono::seconds most_time{2};
    if (update_.valid()) {
      update_.wait_for(most_time);
      is_ending_ = true; // it ends after the stream that it is at
      update_.get();
      is_ending_ = false;
    }
    last_write_ = std::chrono::steady_clock::now();
    if (!isToldToEnd()) {
      if (options_.waits || last_duration_ < most_time) {
        beginUpdate(node);
        waitForUpdate();
      }
      else
        ++left_out_;
    }
    if (const std::string fault = map_.faultOfFrames(); !fault.empty()) {
      console_.error(fault);
      is_left_out_ = true;
    }
    if (map_.tree().size() == 0) {
      console_.error(
          "the map is empty, and not written: no voxel was there, or all are "
          "more than 32768 voxels from the origin");
      is_left_out_ = true;
    }
    else if (isToldToEnd() && std::filesystem::exists(options_.path)) {
      writeUnfinished();
      console_.summary("interrupted: '" + options_.path +
                       "' is still the earlier map; that of " +
                       counted(made_, "update") + " is '" + unfinished_ + "'");
    }
    else {
      write();
      console_.summary(std::to_string(map_.tree().size()) + " nodes written to " +
                       options_.path + ", after " + counted(made_, "update"));
    }
  }

  /** \brief Whether the map was empty in the end, or lacks voxels, which was told. */
  bool
  isLeftOut() const
  {
    return is_left_out_;
  }

  /** \brief Seconds whose frames were inserted, and those left out. Called by any thread.
   */
  nodes::MapCounts
  counts() const
  {
    return {made_, left_out_};
  }

private:
  /** \brief True if a replay is to end before its last frame. */
  bool
  isToldToEnd() const
  {
    return options_.waits && isInterrupted();
  }

  void
  beginUpdate(const nodes::CentralNode& node)
  {
    update_ = std::async(std::launch::async,
                         [this, &node, sensors = sensors_] { insert(node, sensors); });
  }

  /** \brief Waits for the update, which that of a replay ends early if the program is
   * interrupted. */
  void
  waitForUpdate()
  {
    constexpr std::chrono::milliseconds patience{20};
    while (update_.wait_for(patience) != std::future_status::ready)
      is_ending_ = isToldToEnd();
    update_.get();
  }

  struct Sensor {
    nodes::Time since; ///< time of the clouds
    std::optional<std::array<double, 3>> position;
    std::optional<std::array<double, 3>> position_before;
    double full_intensity = 0.0; ///< see MergedMap::insertLatest()
  };

  using Sensors = std::map<std::string, Sensor>;

  void
  insert(const nodes::CentralNode& node, const Sensors& sensors)
  {
    const auto start = std::chrono::steady_clock::now();
    bool is_whole = true;
    bool has_new_frames = false;
    for (const auto& [name, sensor] : sensors) {
      is_whole = !is_ending_;
      if (!is_whole)
        break;
      const auto find_sensor = [&at = sensor](nodes::Time stamp) {
        const auto& position = stamp < at.since ? at.position_before : at.position;
        return position
                   ? std::optional(octomap::point3d(static_cast<float>((*position)[0]),
                                                    static_cast<float>((*position)[1]),
                                                    static_cast<float>((*position)[2])))
                   : std::nullopt;
      };
      has_new_frames |=
          map_.insertLatest(name, sensor.full_intensity, find_sensor, node);
    }
    map_.completeRound();
    if (is_whole)
      made_ += has_new_frames ? 1 : 0;
    else
      left_out_ += isToldToEnd() ? 0 : 1;
    last_duration_ = std::chrono::steady_clock::now() - start;
    constexpr std::chrono::minutes interval{1};
    const auto now = std::chrono::steady_clock::now();
    if (now - last_write_ < interval)
      return;
    last_write_ = now;
    // That of a replay is not complete before its end.
    if (!options_.waits && map_.tree().size() > 0)
      write();
  }

  /** \brief Writes the map: the first time not over a file that appeared since the
   * program began, unless it may be replaced. */
  void
  write()
  {
    writeUnfinished();
    const bool may_replace = options_.may_replace || has_written_;
    const recording::RecordingStatus status = recording::renameFile(
        unfinished_,
        options_.path,
        may_replace ? recording::ExistingFile::Replace : recording::ExistingFile::Keep);
    if (!status.ok())
      throw std::runtime_error(status.message() + "; the map is in '" + unfinished_ +
                               "'");
    has_written_ = true;
  }

  /** \brief Writes the map beside its place. */
  void
  writeUnfinished()
  {
    if (!has_written_)
      throwUnlessOk(recording::setAsideUnfinished(unfinished_, unfinished_));
    const auto written = map_.write(unfinished_);
    if (!written.ok)
      throw std::runtime_error(written.message);
  }

  const CentreMapOptions options_;
  const std::string unfinished_; // name of the map until it is complete
  Console& console_;
  nodes::detail::MergedMap map_;
  Sensors sensors_;
  std::optional<nodes::Time> begin_; // of the clouds
  std::chrono::seconds second_{0};   // that it is, from the begin
  bool is_due_ = false;              // the update for the second before
  std::atomic<std::size_t> made_{0}; // updates
  std::atomic<std::size_t> left_out_{0};
  std::atomic<bool> is_ending_{false};
  bool is_left_out_ = false;
  bool has_told_of_pose_ = false;
  bool has_written_ = false;                            // the file is this program's
  std::chrono::steady_clock::duration last_duration_{}; // of an update
  std::chrono::steady_clock::time_point last_write_ = std::chrono::steady_clock::now();
  std::future<void> update_; // last, as it uses the others
};

} // namespace pcl_ext::tools

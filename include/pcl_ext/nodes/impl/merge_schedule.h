// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/nodes/stream_health.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief How often the streams of a centre are merged, and how long that waits. */
struct MergeScheduleSettings {
  /** \brief From one merged frame to the next, in the time of the clouds; they are at
   * whole multiples of it. 1 ms to 1 hour. */
  Time period = std::chrono::milliseconds(100);

  /** \brief How long a merged frame waits for streams whose frame for it has not arrived
   * yet, 0 to 1 hour. Without losses it waits only as long as the slowest stream
   * takes. */
  Time max_wait = std::chrono::milliseconds(200);

  /** \brief How long a stream is alive after its last frame, in which it is waited for
   * and merged: above the time from one frame of the slowest stream to the next. 1 ms
   * to 1 hour. */
  Time max_age = std::chrono::seconds(2);

  /** \brief Whether merged frames are left out where the caller is too slow for all of
   * them: those after one that is a second late, up to the newest that is due. Else they
   * are all made, however late. */
  bool skips_late = true;

  /** \brief Frames of one stream that are released, at most, from one call of
   * MergeSchedule::countDecoded() to the next: as many as the caller takes. Where others
   * have waited for their turn longer than a period, or 10 s, and 2 s, and skips_late is
   * set, they are all released, for the caller to refuse. So are those of other clocks
   * where skips_late is set. At least 1. */
  std::size_t max_released = std::numeric_limits<std::size_t>::max();
};

/** \brief How many merged frames there were. */
struct MergeCounts {
  std::size_t made = 0;
  std::size_t left_out = 0; ///< see MergeScheduleSettings::skips_late
};

/** \brief What is wrong with settings, in one line; empty if nothing. */
PCL_EXT_EXPORT std::string
faultOf(const MergeScheduleSettings& settings);

/** \brief A frame that arrived for a CentralNode. */
struct ScheduledFrame {
  std::string stream;
  Time stamp{0}; ///< of the cloud
  std::vector<std::uint8_t> bytes;
};

/** \brief Decides which frames of several streams are merged with each other: by the
 * time of their clouds, not of their arrival, so that centres that share the streams
 * merge the same frames as one that has all of them.
 *
 * The merged frame of time T has the latest frame of each stream that is not later than
 * T. Frames that are later are held back until T is merged; T is merged when each stream
 * that is alive has a frame of T or later, or after max_wait. A frame that arrives after
 * its time was merged is decoded at once and is part of the next one.
 *
 * Streams need not have a common clock with this machine, but one with each other: those
 * whose clocks are more than 2 s from the others' median are not held back, nor waited
 * for. The first merged frames are of the streams that are known by then. Where only
 * streams of other clocks go on, merged times go on by the time of their arrival, until
 * the others are too old.
 *
 * Frames that arrive late, as those behind a pause of the link or of this machine, tell
 * nothing of a clock: that of a stream is known by the frame that took the least time to
 * arrive, of the last 2 to 4 s in which there were frames. A clock that is set forward is
 * known by the next frame, and one that is set back by a stamp that goes back by more than
 * a second. Where all streams pause for longer than max_age, it ages them by half of
 * max_age. So the merged frames of a pause are made as its frames arrive, and a stream
 * that has ended is too old after a few pauses.
 *
 * A frame with the stamp of the one before, as where clouds have none, is taken to be as
 * much later as it has arrived later. Merged times go on over times without frames,
 * as where clocks are set forward. They go back where the newest stamp is more than two
 * periods and max_wait before the next merged time: all clocks are set back.
 *
 * All frames are released to be decoded, also where merged frames are left out.
 *
 * Stamps are from 1896 to 2116 (-2^61 to 2^62 ns); others are taken for these.
 *
 * For one thread at a time.
 */
class PCL_EXT_EXPORT MergeSchedule {
public:
  /** \param[in] settings as faultOf() accepts */
  explicit MergeSchedule(const MergeScheduleSettings& settings);

  /** \brief A frame has arrived.
   * \param[in] frame the next one of its stream
   * \param[in] now time of any clock that is not set
   * \return false if its stamp is that of the stream's frame before, so that another one
   * is taken
   */
  bool
  add(ScheduledFrame frame, Time now);

  /** \brief Forgets a stream, and the frames of it that are held back. */
  void
  remove(const std::string& stream)
  {
    streams_.erase(stream);
  }

  /** \brief The frames that are held back, those of a stream in order; nothing is merged
   * with them. */
  std::vector<ScheduledFrame>
  releaseAll();

  /** \brief All frames that were released are decoded; see
   * MergeScheduleSettings::max_released. */
  void
  countDecoded();

  /** \brief No more frames come: what is there is merged without waiting for others. */
  void
  end()
  {
    has_ended_ = true;
  }

  /** \brief Counts the merged frames for which there are frames still as left out; next()
   * is not called any more. */
  void
  leaveOutRest();

  /** \brief What is to be done. */
  struct Step {
    std::vector<ScheduledFrame> frames; ///< to decode now, those of a stream in order
    /** \brief Others are to be decoded before it merges, once countDecoded() is
     * called. */
    bool has_more = false;
    std::optional<Time> merge; ///< then, merge as of this time
    /** \brief Frames from this time on: max_age before merge, or before the newest frame
     * where that is earlier. */
    Time oldest{0};
    std::set<std::string> other_clocks; ///< and with it the latest frames of these
  };

  /** \brief What is to be done now; to be called until a step merges nothing.
   * \param[in] now as above
   */
  Step
  next(Time now);

  const MergeCounts&
  counts() const
  {
    return counts_;
  }

private:
  struct HeldFrame {
    ScheduledFrame frame;
    Time arrival;
  };

  struct Stream {
    std::deque<HeldFrame> held;
    std::optional<Time> given_stamp; ///< of the last frame, as it came
    Time last_arrival{0};
    Time last_stamp{0};
    Time offset{0}; ///< of its clock: the least time of arrival minus stamp
    std::optional<Time> least_offset; ///< of the frames since clocks_since_
    std::size_t released = 0;         ///< and not decoded, as far as it is known
  };

  /** \brief Leaves most of a pause of all streams out of their ages. */
  void
  endPause(Time now);

  /** \brief Forgets frames of before the last window, for all streams at once: so that
   * clocks that go slower, as of a recording, stay close. */
  void
  endClockWindow(Time now);

  static void
  judgeClock(Stream& stream, Time stamp, Time now, bool is_first);

  bool
  isAlive(const Stream& stream, Time now) const;

  /** \brief The median of the offsets of clocks, of the streams that are alive; nothing if
   * none is. */
  std::optional<Time>
  commonOffset(Time now) const;

  /** \brief The multiple of the period at or after a time. */
  Time
  slotOf(Time stamp) const;

  /** \brief The earliest stamp that is held of frames of the common clock. */
  std::optional<Time>
  earliestHeld(Time offset) const;

  /** \brief The newest stamp of the streams that are alive, of the common clock. */
  std::optional<Time>
  newestStamp(Time offset, Time now) const;

  /** \brief Time of arrival minus stamp of the newest frame of the streams that are
   * alive, of the common clock. */
  std::optional<Time>
  latestOffset(Time offset, Time now) const;

  /** \brief True if the clocks of the streams were set back so far that merging begins
   * anew. */
  bool
  areClocksSetBack(Time offset, Time now);

  /** \brief Forgets what is to be merged next, so that it is known by the frames that
   * are held. */
  void
  beginAnew();

  /** \brief The newest multiple of the period that need not wait for frames. */
  Time
  newestDue(Time offset, Time now) const;

  /** \brief True if a frame has been due for so long that the caller is too slow. */
  bool
  isLate(Time offset, Time now) const;

  /** \brief Counts the merged frames for which there are frames as left out.
   * \param[in] end those from this time on are not counted
   */
  void
  countLeftOut(Time offset, Time end);

  /** \brief Leaves merged frames out, if the caller is too slow for them. */
  void
  skipLate(Time offset, Time now);

  /** \brief True if a released frame of a stream is decoded or refused, and does not wait
   * for others. */
  bool
  hasRoom(const Stream& stream, Time now) const;

  void
  releaseFrames(Time offset, Time now, Step& step);

  /** \brief A frame for the slot, or a later one, arrived then. */
  void
  waitSince(Time arrival);

  bool
  isComplete(Time offset, Time now);

  /** \brief True if frames of other clocks are to be merged without a new one of the
   * common clock; the slot is that of their arrival then. */
  bool
  isDueForOthers(Time offset, Time now);

  /** \brief See Step::oldest. */
  Time
  oldestOf(Time merge, Time offset) const;

  const MergeScheduleSettings settings_;
  std::map<std::string, Stream> streams_;
  std::optional<Time> clocks_since_;   // of Stream::least_offset
  std::optional<Time> last_arrival_;   // of any stream
  Time offset_{0};                     // last one that streams had in common
  std::optional<Time> slot_;           // to be merged next
  bool has_frames_ = false;            // of the slot
  std::optional<Time> has_more_since_; // frames for it that cannot be released
  std::optional<Time> waiting_since_;  // arrival of the first frame for it
  std::set<Time> other_slots_;         // when frames of other clocks came
  Time ahead_{0};        // of the common clock's frames, as only others came
  bool is_late_ = false; // until nothing was left out
  bool has_ended_ = false;
  MergeCounts counts_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/status.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \addtogroup nodes
 * @{ */

/** \brief All settings of a CentralNode, with their units, defaults and ranges. */
struct CentralNodeSettings {
  /** \brief Voxel edge of the common grid that streams are merged on, metres. 1e-6 to
   * 1e6. Not finer than that of the streams, whose voxels lie apart otherwise. */
  double resolution = io::GridSettings().resolution;

  /** \brief Origin of the common grid: world position, metres, from which its voxels
   * are counted, 2^20 each way. None: the world's origin; while voxels lie further out,
   * a corner of its voxels amid one of the streams, from which the most voxels are
   * counted. */
  std::optional<std::array<double, 3>> origin;

  /** \brief Threads that decode, up to 1024; 0: one for each core. */
  unsigned int threads = 0;

  /** \brief Frames of one stream that may wait to be decoded, at least 1; further ones
   * are refused, which bounds the memory of a stream that is too fast. */
  std::size_t max_waiting_frames = 40;

  /** \brief Streams whose last frame was decoded earlier do not take part in merging.
   * Above 0. */
  Time max_merge_age = std::chrono::seconds(2);

  /** \brief Limits of decoding, for each stream; as anybody may send, free_voxels is
   * 2^20. The budget is for all of them, their latest voxels and outlier filters
   * included; none: a quarter of the machine's memory. */
  io::DecoderLimits decoder_limits = defaultLimits();

  /** \brief Clock for rates, latencies and ages. */
  Clock clock = systemTime;

  static io::DecoderLimits
  defaultLimits()
  {
    io::DecoderLimits limits;
    limits.free_voxels = std::size_t{1} << 20;
    return limits;
  }
};

/** \brief Outcome codes of a CentralNode. */
enum class CentralNodeCode {
  Ok,
  InvalidSettings, ///< a setting is outside its range
  UnknownStream,   ///< there is no stream of this name
  StreamExists,    ///< there is a stream of this name already
  TooManyWaiting,  ///< the frame was refused
  OutOfMemory      ///< memory ran out; the frame was refused
};

/** \brief Outcome of a call to a CentralNode. */
using CentralNodeStatus = Status<CentralNodeCode>;

/** \brief A frame that was received, decoded or not. Valid during the listener's
 * call. */
struct ReceivedFrame {
  const std::string& stream;
  Time stamp; ///< given with it, else in it; 0: none
  /** \brief Ok, with a warning where points of a scan are left out as they have no voxel;
   * or why there are no voxels. */
  const io::CompressionStatus& status;
  /** \brief Returns the denoised voxels; empty unless the status is Ok. The listener may
   * call it: where the frame tells changes only, the voxels are listed then; without
   * memory for them they are empty. */
  const std::function<const io::VoxelFrame&()>& voxels;
  const io::CodedFrameStatistics& statistics; ///< before denoising; all 0 unless Ok

  /** \brief True to request an I-frame from the sender of the stream, by CloudSender,
   * which is thread-safe as the listener has to be, or from the thread of the
   * SensorNode. Set for the first frame that fails as bytes, a frame before it or memory
   * are missing, and for every third such frame after it until one is decoded; also for
   * every third of consecutive late frames, as all frames of a restarted sender may look
   * late. Not for bytes without a frame and for frames that this node refuses in any
   * case. */
  bool wants_i_frame;
};

/** \brief Stamps of frames, both included. */
struct StampRange {
  Time oldest{0};
  Time newest{0};
  /** \brief Streams whose latest frame takes part whatever its stamp. */
  std::set<std::string> streams = {};
};

/** \brief The frame that the latest voxels of a stream are from. */
struct LatestFrame {
  Time stamp{0};          ///< given with it, else in it; 0: none
  std::size_t number = 0; ///< decoded frames of the stream up to and including it
};

/** \brief What of a stream is in a merged frame. */
struct MergedStream {
  std::string name;
  /** \brief The frame whose voxels are merged; none: the stream has no frame that was
   * decoded within CentralNodeSettings::max_merge_age. */
  std::optional<LatestFrame> frame;
};

/** \brief How the voxels of a merged frame differ from those merged before. */
struct MergedChanges {
  /** \brief Without those that went and with those that came the voxels of the one are
   * those of the other. From nothing, with all voxels as those that came, where that is not
   * known: the first merged frame, those with colours or with intensities other than whole
   * numbers of 0 to 65535, another grid or scale, where half of all changes, and after a
   * failure. */
  io::VoxelChanges voxels;

  /** \brief How many times merge() and mergeChanges() were called so far; 0: they failed. */
  std::size_t number = 0;
};

/** \brief Outcome of CentralNode::merge. */
struct MergeStatus : CentralNodeStatus {
  using CentralNodeStatus::CentralNodeStatus;

  /** \brief All streams, by name; empty unless ok(). */
  std::vector<MergedStream> streams;

  /** \brief The oldest stamp of the merged frames: the age of the oldest voxels.
   * Nothing if no frame has a stamp. */
  std::optional<Time>
  oldestStamp() const
  {
    std::optional<Time> oldest;
    for (const MergedStream& stream : streams)
      if (stream.frame && stream.frame->stamp != Time(0) &&
          (!oldest || stream.frame->stamp < *oldest))
        oldest = stream.frame->stamp;
    return oldest;
  }
};

/** \brief Called for every frame, in the order of its stream. Calls for different
 * streams come from several threads at once, those for one stream one at a time. Must
 * not throw. */
using FrameListener = std::function<void(const ReceivedFrame&)>;

/** \brief The central computer's part: decodes many streams on all cores, denoises them
 * and merges them on a common grid (section 2.7 of the paper). Independent of ROS.
 *
 * Each stream has a decoder of its own; its frames are decoded in the order in which
 * they are received. Streams with waiting frames take turns of one frame each. All
 * members are thread-safe.
 *
 * An exception while a frame is decoded, std::bad_alloc included, becomes that frame's
 * status, and the stream continues. A call that runs out of memory throws
 * std::bad_alloc, except for receive() and merge(), which return a status; the node is
 * then unchanged.
 */
class PCL_EXT_EXPORT CentralNode {
public:
  /** \brief A node without streams.
   * \param[in] settings checked here; see settingsStatus()
   * \param[in] listener called for every frame; may be empty
   */
  explicit CentralNode(const CentralNodeSettings& settings,
                       FrameListener listener = FrameListener());

  /** \brief Waits until every waiting frame is decoded. */
  ~CentralNode();
  CentralNode(const CentralNode&) = delete;
  CentralNode&
  operator=(const CentralNode&) = delete;

  /** \brief Ok, or InvalidSettings with the setting and its value; every other call
   * then returns the same, or does nothing. */
  const CentralNodeStatus&
  settingsStatus() const;

  /** \brief No intensity is below it; native ones may be negative. */
  static constexpr float lowest_intensity = -std::numeric_limits<float>::infinity();

  /** \brief Adds a stream.
   * \param[in] name not empty, and not that of another stream
   * \param[in] min_intensity voxels below it are noise, in the unit of the decoded
   * intensities; not NaN; lowest_intensity: none is
   */
  CentralNodeStatus
  addStream(const std::string& name, float min_intensity = lowest_intensity);

  /** \brief Removes a stream, with its voxels and its health. Frames of it that wait are
   * decoded yet, and the listener is called for them.
   * \return UnknownStream if there is none of this name
   */
  CentralNodeStatus
  removeStream(const std::string& name);

  /** \brief Changes the threshold of a stream, from the next frame on that is decoded.
   * \param[in] name of the stream
   * \param[in] min_intensity as above
   */
  CentralNodeStatus
  setMinIntensity(const std::string& name, float min_intensity);

  /** \brief Sets whether the frames of a stream come without the layout of the messages
   * that it is made of (io::VoxelFrame::layout), from the next frame on that is decoded.
   * They come with it, if the stream tells. */
  CentralNodeStatus
  setPacked(const std::string& name, bool is_packed);

  /** \brief Sets the outlier removal of a stream, from the next frame on that is
   * decoded. It is applied before min_intensity and before merging. Off by default.
   *
   * The filter keeps a history of the decoded frames, see VoxelOutlierRemoval, across
   * I-frames and frames that fail. Other settings than before make a new filter with an
   * empty history. Where a frame cannot be judged it stays unchanged:
   * StreamHealth::outlier_removal says why, and whether it was judged without
   * intensities. Name DensityUnit::Points for counts of depth cameras.
   * \param[in] name of the stream
   * \param[in] settings as checkSettings() accepts; none: no outliers are removed
   * \return InvalidSettings or UnknownStream if nothing was changed
   */
  CentralNodeStatus
  setOutlierRemoval(const std::string& name,
                    const std::optional<VoxelOutlierRemovalSettings>& settings);

  /** \brief Takes a stream's next frame, to decode it as soon as there is a thread.
   * \param[in] name of the stream
   * \param[in] bytes one frame of any format; any other bytes count as a failed frame
   * \param[in] stamp time of the cloud, for the latency; none: that in the frame, if
   * any
   * \return Ok if the frame waits to be decoded
   */
  CentralNodeStatus
  receive(const std::string& name,
          std::vector<std::uint8_t> bytes,
          std::optional<Time> stamp = std::nullopt);

  /** \brief Returns when no frame waits and the listener was called for all of them.
   * Not to be called by the listener. */
  void
  waitUntilDecoded();

  /** \brief The same, but not longer than a time.
   * \return false if frames wait still
   */
  bool
  waitUntilDecoded(Time timeout);

  /** \brief Refuses the frames that wait, and counts them so; returns when those that are
   * being decoded are done. Not to be called by the listener. */
  void
  refuseWaiting();

  /** \brief The latest voxels of a stream, of any age.
   * \param[in] name of the stream
   * \param[out] voxels denoised; empty if there are none
   * \return the frame that they are from; nothing if the stream is unknown or has none
   */
  std::optional<LatestFrame>
  latestVoxels(const std::string& name, io::VoxelFrame& voxels) const;

  /** \brief The latest voxels of all streams, merged.
   *
   * A voxel of a stream is added to the voxel of the common grid that contains its
   * centre, the upper one for a centre on the boundary, in double precision whatever
   * the origins of the streams. Intensities are summed over the streams, as they are
   * over points (section 2.5.4 of the paper); merge streams of one law only. Voxels of
   * streams without intensities count 1. The colour is the mean of those voxels that
   * have one, each with the same weight, or black where no stream has one. Voxels
   * outside the common grid are left out. Where one of several streams has intensities
   * beside which a typical one would be less than a step, above 65535 times it, they
   * are reduced: to 1024 times the typical intensity, or to 65535 steps of the
   * intensities if that is more. Typical is the median of the streams' medians, of two
   * the lower one. health() has the number of both.
   *
   * Sums are kept from one call to the next: what has changed in a stream since then is
   * added or taken away, by several threads. All voxels of all streams are entered again
   * where the common grid or the limit of intensities is another one, and where what has
   * changed is not known: behind removeStream(), and of a stream whose frames were not
   * merged for longer than 64 of them.
   * \param[out] merged voxels [i d_v, (i+1) d_v) about the origin of the common grid;
   * intensities exact while all are whole numbers of 0 to 65535, else to 1/32768 of the
   * largest; colours of 8 bits if a stream has colours; empty unless ok()
   * \param[in] stamps streams whose latest frame has one of these take part, too, however
   * long ago it was decoded: for frames that are merged by the times of their clouds
   * \return Ok and what is merged, or OutOfMemory: the streams keep their voxels for
   * the next call
   */
  MergeStatus
  merge(io::VoxelFrame& merged, const std::optional<StampRange>& stamps = std::nullopt);

  /** \brief As merge(), but tells what has changed since the last call of either, in less
   * time where that is little.
   * \param[out] changes from the voxels that were merged then to those that merge()
   * would return now, which have the same intensities, maybe on a scale of fewer bits; no
   * voxels unless ok()
   */
  MergeStatus
  mergeChanges(MergedChanges& changes,
               const std::optional<StampRange>& stamps = std::nullopt);

  /** \brief The voxels that were merged last, as merge() returned them or would have; none
   * if that failed.
   * \throws std::bad_alloc without memory; there are no voxels then */
  void
  mergedVoxels(io::VoxelFrame& merged) const;

  /** \brief Health of the streams, by name. */
  std::vector<StreamHealth>
  health() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::nodes

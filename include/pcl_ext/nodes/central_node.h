#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/compression_status.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/status.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief All settings of a CentralNode, with their units, defaults and ranges. */
struct CentralNodeSettings {
  /** \brief Voxel edge of the common grid that streams are merged on, metres. 1e-6 to
   * 1e6; by default that of the sensors' settings. */
  double resolution = io::IntensityCompressionSettings().resolution;

  /** \brief Threads that decode, up to 1024; 0: one for each core. */
  unsigned int threads = 0;

  /** \brief Frames of one stream that may wait to be decoded, at least 1; more are
   * refused, so that a stream that is too fast costs neither memory nor the others. */
  std::size_t max_waiting_frames = 40;

  /** \brief Streams whose last frame is older do not take part in merging. Above 0. */
  Time max_merge_age = std::chrono::seconds(1);

  /** \brief What decoding one stream may cost. */
  io::DecoderLimits decoder_limits;

  /** \brief Tells the time for rates, latencies and ages. */
  Clock clock = systemTime;
};

/** \brief What came of an order to a CentralNode. */
enum class CentralNodeCode {
  Ok,
  InvalidSettings, ///< a setting is outside its range
  UnknownStream,   ///< there is no stream of this name
  StreamExists,    ///< there is one already
  TooManyWaiting,  ///< the frame was refused
  OutOfMemory      ///< memory ran out; the frame was refused
};

/** \brief Outcome of an order to a CentralNode. */
using CentralNodeStatus = Status<CentralNodeCode>;

/** \brief A frame that was received, decoded or not. Valid during the listener's call. */
struct ReceivedFrame {
  const std::string& stream;
  Time stamp;                          ///< as it was received with
  const io::CompressionStatus& status; ///< Ok, or why there are no voxels
  const io::VoxelFrame& voxels;        ///< denoised; empty unless the status is Ok
  const io::CodedFrameStatistics& statistics; ///< before denoising; all 0 unless Ok

  /** \brief The stream cannot go on without an I-frame; ask its sender for one. Said with
   * the first frame that fails, and with every third after it until one is decoded; also
   * with every third that comes late without one between that is decoded, as all frames of
   * a sender that began again may look late. */
  bool wants_i_frame;
};

/** \brief Which frame of a stream its latest voxels are of. */
struct LatestFrame {
  Time stamp{0};          ///< as it was received with; 0: with none
  std::size_t number = 0; ///< frames of the stream that were decoded, it included
};

/** \brief Told of every frame, in the order of its stream; called by several threads at
 * once, though by one at a time for one stream. Must not throw. */
using FrameListener = std::function<void(const ReceivedFrame&)>;

/** \brief What the central computer does: decodes many streams on all cores, denoises
 * them and merges them on a common grid (section 2.7 of the paper). Knows no ROS.
 *
 * Each stream has a decoder of its own; its frames are decoded in the order in which they
 * are received. Streams that frames wait of take turns, a frame each, so that none waits
 * for the many frames of another. All members may be called by several threads at once.
 *
 * Memory that runs out while a frame is decoded, or whatever else is thrown then, is that
 * frame's status, and the stream goes on. Memory that runs out in a call is thrown as
 * std::bad_alloc, by receive() said as a status, and leaves the node as it was.
 */
class PCL_EXT_EXPORT CentralNode {
public:
  /** \brief A node without streams.
   * \param[in] settings checked here; see settingsStatus()
   * \param[in] listener told of every frame; may be empty
   */
  explicit CentralNode(const CentralNodeSettings& settings,
                       FrameListener listener = FrameListener());

  /** \brief Ends when every frame that waits is decoded. */
  ~CentralNode();
  CentralNode(const CentralNode&) = delete;
  CentralNode&
  operator=(const CentralNode&) = delete;

  /** \brief Ok, or InvalidSettings with the setting and its value; every other call then
   * says the same, or does nothing. */
  const CentralNodeStatus&
  settingsStatus() const;

  /** \brief Adds a stream.
   * \param[in] name not empty, and not that of another stream
   * \param[in] min_intensity voxels below it are noise, in the unit of the decoded
   * intensities; not NaN; 0 keeps all voxels
   */
  CentralNodeStatus
  addStream(const std::string& name, float min_intensity = 0.0f);

  /** \brief Changes what a stream takes for noise, from the next frame on that is decoded.
   * \param[in] name of the stream
   * \param[in] min_intensity as above
   */
  CentralNodeStatus
  setMinIntensity(const std::string& name, float min_intensity);

  /** \brief Has a stream's outliers removed, from the next frame on that is decoded; its
   * own voxels are judged, before min_intensity and before merging. Off at first.
   *
   * The filter sees the frames that are decoded, in their order, and remembers them as
   * VoxelOutlierRemoval says, beyond I-frames and frames that fail. Every call makes a new
   * filter, which remembers nothing. See there for what it is made for: streams of native
   * intensities or of lidars it harms, and those of other voxel edges stay as they are.
   * \param[in] name of the stream
   * \param[in] settings as checkSettings() accepts; none: no outliers are removed
   * \return InvalidSettings or UnknownStream if nothing was changed
   */
  CentralNodeStatus
  setOutlierRemoval(const std::string& name,
                    const std::optional<VoxelOutlierRemovalSettings>& settings);

  /** \brief Takes a stream's next frame, to decode it as soon as there is a thread.
   * \param[in] name of the stream
   * \param[in] bytes one frame of any format; other bytes are safe, and a failed frame
   * \param[in] stamp time of the cloud, for the latency; none: that which the frame
   * carries, if any
   * \return Ok if the frame waits to be decoded
   */
  CentralNodeStatus
  receive(const std::string& name,
          std::vector<std::uint8_t> bytes,
          std::optional<Time> stamp = std::nullopt);

  /** \brief Returns when no frame waits to be decoded, and the listener was told of all.
   * Not to be called by the listener. */
  void
  waitUntilDecoded();

  /** \brief The voxels that a stream showed last, however old they are.
   * \param[in] name of the stream
   * \param[out] voxels denoised; empty if there are none
   * \return which frame they are of; nothing if the stream is unknown or has shown none
   */
  std::optional<LatestFrame>
  latestVoxels(const std::string& name, io::VoxelFrame& voxels) const;

  /** \brief The voxels of all streams as of now, merged.
   *
   * A voxel of a stream goes to the voxel of the common grid that holds its centre, which
   * is the one above for a centre on a face; its intensity there is the sum over the
   * streams, as it is over points (section 2.5.4 of the paper), so that streams of one law
   * should be merged with each other.
   * \param[out] merged voxels [i d_v, (i+1) d_v) about the world origin; intensities
   * exact while all are whole numbers below 65536, else to 1/65535 of the largest
   */
  void
  merge(io::VoxelFrame& merged);

  /** \brief How the streams are doing, in the order of their names. */
  std::vector<StreamHealth>
  health() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace nodes
} // namespace pcl_ext

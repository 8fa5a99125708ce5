// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \addtogroup recording
 * @{ */

/** \brief A stream of a recording. */
struct RecordedStream {
  std::string name;       ///< topic of the channel; .pcxi: name of the file
  std::size_t frames = 0; ///< number of frames
  bool has_times = false; ///< false: all times are 0
  Time first_time{0};     ///< of the frames
  Time last_time{0};
  std::map<std::string, std::string> metadata; ///< of the channel
  std::size_t channel = 0; ///< MCAP: number of the channel in the file, from 0
};

/** \brief An encoded frame of a recording. */
struct RecordedFrame {
  std::size_t stream = 0;   ///< index in RecordingReader::streams()
  std::size_t number = 0;   ///< of the frame in its stream, from 0
  Time time{0};             ///< at which it was recorded
  Time stamp{0};            ///< of the cloud; 0: unknown
  std::string frame_id;     ///< coordinate frame of the voxels; empty if unknown
  std::uint64_t offset = 0; ///< byte of the file at which the frame or its chunk begins
  std::vector<std::uint8_t> bytes;
  io::FrameDescription description;
};

/** \brief Reads recordings: .pcxi files, MCAP files and rosbag2 folders with messages
 * of the type point_cloud_interfaces/msg/CompressedPointCloud2 and a format of pcl_ext.
 *
 * Files that were cut off or damaged are read as far as possible; damage() tells where
 * not. Instances are for one thread at a time.
 * \code
 * pcl_ext::recording::RecordingReader reader;
 * auto status = reader.open("cell.mcap");
 * pcl_ext::recording::RecordedFrame frame;
 * while (status.ok() && (status = reader.next(frame)).ok())
 *   std::cout << reader.streams()[frame.stream].name << ' ' << frame.bytes.size()
 *             << '\n';
 * \endcode
 */
class PCL_EXT_RECORDING_EXPORT RecordingReader {
public:
  RecordingReader();
  ~RecordingReader();
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader&
  operator=(RecordingReader&&) noexcept;

  /** \brief Opens a recording. The kind of a file is found by its content.
   * \param[in] path a file, a rosbag2 folder, or - for the standard input
   * \return NotARecording if there are no frames, with what there is instead
   */
  RecordingStatus
  open(const std::string& path);

  const std::vector<RecordedStream>&
  streams() const;

  /** \brief Reads the next frame of all streams in the order of their times.
   * \return EndOfRecording after the last one. Damaged: this frame cannot be read, and
   * the next call goes on after it; stream, number, time and offset are set
   */
  RecordingStatus
  next(RecordedFrame& frame);

  /** \brief Continues next() with the first frame of this time or later. */
  void
  seek(Time time);

  /** \brief Reads one frame.
   * \param[in] stream index in streams()
   * \param[in] number of the frame in its stream
   */
  RecordingStatus
  read(std::size_t stream, std::size_t number, RecordedFrame& frame);

  /** \brief Number of the last frame of a stream that is not later than a time; nothing
   * if all are. */
  std::optional<std::size_t>
  frameAt(std::size_t stream, Time time) const;

  /** \brief Time of a frame, without reading it; that of the frame before in its stream
   * if the clock was set back between them, and of the one after it if it alone is later
   * than that. Orders the frames of all streams. */
  Time
  timeOf(std::size_t stream, std::size_t number) const;

  /** \brief Number of the I-frame from which a frame can be decoded: the last one that
   * is not after it. 0 if there is none. */
  std::size_t
  iFrameBefore(std::size_t stream, std::size_t number);

  /** \brief What could not be read until now. */
  const std::vector<RecordingDamage>&
  damage() const;

  /** \brief True if the recording has no orderly end, as after a power failure. */
  bool
  isUnfinished() const;

  /** \brief Bytes of the file or files. */
  std::uint64_t
  fileBytes() const;

  /** \brief Paths of the file, or of the files of a rosbag2 folder in their order. */
  const std::vector<std::string>&
  files() const;

private:
  friend class RecordedStreamDecoder;
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** \brief Decodes the frames of one stream of a recording in any order. A frame that
 * does not follow the last one is decoded from the I-frame before it on, and so is one
 * whose reference was dropped for DecoderLimits::budget. Not at the same time as another
 * decoder of the reader, or the reader. */
class PCL_EXT_RECORDING_EXPORT RecordedStreamDecoder {
public:
  /** \param[in] reader must outlive this
   * \param[in] stream index in its streams
   * \param[in] limits of decoding
   */
  RecordedStreamDecoder(RecordingReader& reader,
                        std::size_t stream,
                        const io::DecoderLimits& limits = io::DecoderLimits());
  ~RecordedStreamDecoder();
  RecordedStreamDecoder(RecordedStreamDecoder&&) noexcept;
  RecordedStreamDecoder&
  operator=(RecordedStreamDecoder&&) noexcept;

  /** \brief Whether frames that have their points get their voxels, too; see
   * FrameDecoder::setDecodesVoxels(). */
  void
  setDecodesVoxels(bool decodes_voxels);

  /** \brief Decodes a frame of the stream.
   * \param[in] number of the frame
   * \param[out] voxels empty unless the status is Ok
   * \return that of the decoder; InputFailed if the recording is damaged there or has
   * no such frame
   */
  io::CompressionStatus
  decode(std::size_t number, io::VoxelFrame& voxels);

  /** \brief Decodes the next frame of the stream, which next() of the reader returned;
   * for programs that read all frames in their order.
   * \param[in] frame of this stream
   * \param[out] voxels empty unless the status is Ok
   */
  io::CompressionStatus
  decode(const RecordedFrame& frame, io::VoxelFrame& voxels);

  /** \brief Figures of the last frame that was decoded. */
  const io::CodedFrameStatistics&
  statistics() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::recording

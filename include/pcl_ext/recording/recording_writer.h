// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \addtogroup recording
 * @{ */

/** \brief A stream that is recorded. */
struct StreamToRecord {
  std::string name; ///< topic of the channel, not empty, unlike those of other streams
  std::string frame_id; ///< coordinate frame of the voxels, where the frames have none
  std::map<std::string, std::string> metadata; ///< of the channel, such as sensor poses
};

/** \brief Records the encoded frames of one or several streams.
 *
 * A path that ends in .pcxi is a file of one stream: its frames one after the other, as
 * OctreePointCloudIntensityCompression writes them to a stream. One that ends in .mcap
 * is MCAP: a channel for each stream with messages of the type
 * point_cloud_interfaces/msg/CompressedPointCloud2, whose chunks begin at I-frames. One
 * without an extension is a folder of rosbag2 with such a file. The path - is the
 * standard output, and .pcxi there.
 *
 * \code
 * pcl_ext::recording::RecordingWriter writer;
 * std::size_t stream = 0;
 * auto status = writer.open("cell.mcap");
 * if (status.ok())
 *   status = writer.addStream({"/sensor_1", "world", {}}, stream);
 * if (status.ok())
 *   status = writer.append(stream, time, bytes.data(), bytes.size()); // each frame
 * if (status.ok())
 *   status = writer.finish();
 * \endcode
 */
class PCL_EXT_RECORDING_EXPORT RecordingWriter {
public:
  RecordingWriter();

  /** \brief Removes an unfinished recording without a frame; another one stays, with
   * ".unfinished" added to its name. */
  ~RecordingWriter();
  RecordingWriter(RecordingWriter&&) noexcept;
  RecordingWriter&
  operator=(RecordingWriter&&) noexcept;

  /** \brief Begins a recording, beside its final name until finish().
   * \param[in] path see above
   * \return InvalidArgument for other extensions; OutputFailed also for a device, a pipe
   * and a folder that exists
   */
  RecordingStatus
  open(const std::string& path);

  /** \brief Adds a stream.
   * \param[in] stream .pcxi: only one
   * \param[out] number for append()
   */
  RecordingStatus
  addStream(const StreamToRecord& stream, std::size_t& number);

  /** \brief Appends the next frame of a stream.
   * \param[in] stream number of addStream()
   * \param[in] time of the cloud; not negative; not used by .pcxi, whose frames
   * have the stamp that they were encoded with
   * \param[in] bytes one frame, of either format
   * \param[in] size number of bytes
   * \return InvalidArgument if time or bytes are not as above; nothing is written then,
   * and P-frames that need the missing one are refused, too, until the next I-frame
   */
  RecordingStatus
  append(std::size_t stream, Time time, const std::uint8_t* bytes, std::size_t size);

  /** \brief Writes all frames at hand to the file, for a reader of the unfinished
   * file. */
  RecordingStatus
  flush();

  /** \brief Bytes of the recording so far, with frames that are still at hand; finish()
   * adds an index to MCAP. */
  std::uint64_t
  bytes() const;

  /** \brief Completes the recording and gives it its name. Without success it ends, too,
   * and what was written stays, with ".unfinished" added to its name.
   * \param[in] existing what becomes of a file of that name
   */
  RecordingStatus
  finish(ExistingFile existing = ExistingFile::Replace);

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::recording

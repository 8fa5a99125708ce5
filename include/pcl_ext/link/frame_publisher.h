// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/link/link_settings.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \addtogroup link
 * @{ */

/** \brief Figures of a FramePublisher, since it was made. */
struct PublisherStatistics {
  /** \brief Those that the server has: it has brought back a message of the publisher to
   * itself, an echo, that was sent after them. */
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0;            ///< of these
  std::uint64_t frames_under_way = 0; ///< handed to the connection, no echo yet
  std::uint64_t frames_not_sent =
      0; ///< the connection was lost, or they were too large or not permitted
  /** \brief Those of frames_not_sent that were handed to a connection which was lost
   * before an echo came: the server may have them. */
  std::uint64_t frames_unanswered = 0;
  std::uint64_t i_frame_requests = 0; ///< received
  std::uint64_t violations = 0; ///< what the server did not permit, frames for one
  std::uint64_t reconnections = 0;
  bool is_connected = false; ///< to a server that answers within 1.5 s, now
  std::optional<std::chrono::nanoseconds>
      age; ///< since the last one of `frames` was published; none: there is none
};

/** \brief Publishes the frames of streams, each on the subject SITE.STREAM.frames.
 *
 * Frames that cannot be sent are not kept, nor are those of the time in which the server
 * does not answer: a later one of the same stream arrives with a
 * gap before it, for which receivers request an I-frame. Lost connections are restored
 * for ever, after which, as when the server answers again, an I-frame of each stream is
 * requested. All members are
 * thread-safe; nothing throws.
 * \code
 * pcl_ext::link::LinkSettings settings;
 * settings.servers = "nats://centre:4222";
 * settings.site = "cell";
 * pcl_ext::io::IFrameRequests requests; // at most every second frame is an I-frame
 * pcl_ext::link::FramePublisher publisher(
 *     settings, [&](std::size_t) { requests.add(); });
 * std::size_t stream = 0;
 * auto status = publisher.connect();
 * if (status.ok())
 *   status = publisher.addStream("/sensor_1", {}, stream);
 * // each frame:
 * if (requests.take())
 *   encoder.requestIFrame();
 * encoder.encode(cloud, sensor_to_world, bytes); // a nodes::SensorNode
 * requests.countFrame();
 * status = publisher.publish(stream, time, bytes.data(), bytes.size());
 * \endcode
 */
class PCL_EXT_LINK_EXPORT FramePublisher {
public:
  /** \brief Called when a receiver needs an I-frame of a stream, which its encoder is to
   * make the next frame, see io::IFrameRequests. Called by other threads; must not
   * throw. */
  using RequestIFrame = std::function<void(std::size_t stream)>;

  /** \param[in] settings checked by connect()
   * \param[in] request_i_frame may be empty: receivers wait for the next one
   */
  explicit FramePublisher(const LinkSettings& settings,
                          RequestIFrame request_i_frame = RequestIFrame());

  /** \brief Sends what waits, within the connect_timeout, and ends the connection. */
  ~FramePublisher();
  FramePublisher(const FramePublisher&) = delete;
  FramePublisher&
  operator=(const FramePublisher&) = delete;

  /** \brief Connects to the first server that answers.
   * \return Refused also where the server does not permit this user to publish and to
   * subscribe to SITE.*.echo
   */
  LinkStatus
  connect() noexcept;

  /** \brief Adds a stream.
   * \param[in] name any bytes, 1 to 1000, such as a topic; unlike those of others
   * \param[in] metadata sent with each I-frame
   * \param[out] stream number for publish(), from 0
   */
  LinkStatus
  addStream(const std::string& name,
            const StreamMetadata& metadata,
            std::size_t& stream) noexcept;

  /** \brief Sends the next frame of a stream.
   * \param[in] stream number of addStream()
   * \param[in] time of the cloud
   * \param[in] frame exactly one, of either format
   * \param[in] size number of bytes
   * \return NotConnected or FrameTooLarge, which count as lost
   */
  LinkStatus
  publish(std::size_t stream,
          Time time,
          const std::uint8_t* frame,
          std::size_t size) noexcept;

  /** \brief Waits until the server has all frames that were published.
   * \param[in] timeout above 0
   * \return false if it has not after that time
   */
  bool
  flush(std::chrono::milliseconds timeout) noexcept;

  PublisherStatistics
  statistics() const noexcept;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::link

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/link/link_settings.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \addtogroup link
 * @{ */

/** \brief What a FrameSubscriber receives. */
struct SubscriberSettings {
  LinkSettings link;

  /** \brief Streams to receive by name; empty: all of the site. */
  std::vector<std::string> streams;

  /** \brief The part of the streams to receive, where the server divides them among
   * several centres, see doc/site.md; none: all parts. */
  std::optional<unsigned int> partition;

  /** \brief Frames that the server keeps, from this time of their arrival on, in place
   * of live ones; they come as fast as they are taken, up to the last one that is kept
   * when it begins, and no I-frames are requested. 0: all that it keeps. See
   * keepFrames(). */
  std::optional<Time> replay_from;

  /** \brief Bytes of frames that may wait for next(), at least 1. Further frames are
   * dropped; their streams continue at the next I-frame, which is requested. */
  std::size_t max_waiting_bytes = std::size_t{64} << 20;

  /** \brief Streams that are received; frames of further ones are dropped, at least
   * 1. */
  std::size_t max_streams = 4096;

  /** \brief Time between two requests for an I-frame of one stream, at least 1 ms. It
   * doubles while none comes, up to 16-fold. */
  std::chrono::milliseconds i_frame_request_interval{100};
};

/** \brief A frame that arrived. */
struct LinkFrame {
  std::string stream; ///< name, as it was given to FramePublisher::addStream()
  Time time{0};       ///< of the cloud
  Time kept{0};       ///< time of its arrival at the server; of a replay only
  std::vector<std::uint8_t> bytes;
  bool is_i_frame = false;
  StreamMetadata metadata; ///< of the stream; I-frames only
};

/** \brief Figures of one stream, since its first message arrived. */
struct LinkStreamStatistics {
  std::string name;
  std::uint64_t frames = 0;           ///< returned by next(), or waiting for it
  std::uint64_t bytes = 0;            ///< of these
  std::uint64_t frames_lost = 0;      ///< gaps in the publisher's numbers
  std::uint64_t frames_dropped = 0;   ///< next() was called too rarely
  std::uint64_t frames_skipped = 0;   ///< could not be decoded after a gap
  std::uint64_t frames_early = 0;     ///< came before the first I-frame
  std::uint64_t frames_late = 0;      ///< repeated, or older than their predecessor
  std::uint64_t frames_damaged = 0;   ///< their checksum is wrong
  std::uint64_t messages_invalid = 0; ///< no frames of this library
  std::uint64_t i_frame_requests = 0; ///< sent
  std::uint64_t publishers = 0;       ///< how often one began, the first time included
  std::optional<std::chrono::nanoseconds>
      age; ///< since the last frame; none: none came
};

/** \brief Figures of a FrameSubscriber, since it was made. */
struct SubscriberStatistics {
  std::vector<LinkStreamStatistics> streams; ///< by name
  std::uint64_t messages_of_no_stream = 0;   ///< a subject that names none
  std::uint64_t messages_of_too_many = 0;    ///< of streams beyond max_streams
  std::uint64_t violations = 0;              ///< what the server did not permit
  bool is_refused = false;                   ///< it permits none of the subscriptions
  std::uint64_t reconnections = 0;
  std::uint64_t replay_pending = 0; ///< messages that a replay has still to bring
  bool is_connected = false;        ///< to the server, now
};

/** \brief Receives the frames of a site's streams.
 *
 * A stream's frames come in the order of its publisher: from an I-frame on without a
 * gap, and only those whose checksum is right, which includes that of the frame before.
 * After a gap or a damaged frame, and for a stream that is new, an I-frame is requested,
 * and the frames before it are skipped. Frames of two publishers of one stream never
 * follow each other without an I-frame between them. Late frames are left out; where
 * nothing else comes, as after a number that was too high, the stream begins anew with
 * an I-frame. What is not seen without decoding is a payload that no encoder writes,
 * with the right checksum, and damage in the published layout, which has none.
 * All members are thread-safe; nothing throws.
 * \code
 * pcl_ext::link::SubscriberSettings settings;
 * settings.link.servers = "nats://centre:4222";
 * settings.link.site = "cell";
 * pcl_ext::link::FrameSubscriber subscriber(settings);
 * if (const auto status = subscriber.connect(); !status.ok())
 *   return fail(status.message());
 * pcl_ext::link::LinkFrame frame;
 * for (;;) {
 *   const auto status = subscriber.next(frame, std::chrono::seconds(1));
 *   if (status.ok())
 *     std::cout << frame.stream << ' ' << frame.bytes.size() << '\n';
 *   else if (status.code() != pcl_ext::link::LinkCode::NoFrame)
 *     return fail(status.message());
 * }
 * \endcode
 */
class PCL_EXT_LINK_EXPORT FrameSubscriber {
public:
  /** \param[in] settings checked by connect() */
  explicit FrameSubscriber(const SubscriberSettings& settings);
  ~FrameSubscriber();
  FrameSubscriber(const FrameSubscriber&) = delete;
  FrameSubscriber&
  operator=(const FrameSubscriber&) = delete;

  /** \brief Connects to the first server that answers; frames arrive from now on. */
  LinkStatus
  connect() noexcept;

  /** \brief Returns the next frame.
   * \param[out] frame unchanged unless Ok
   * \param[in] timeout how long to wait for one; 0: not at all
   * \return NoFrame, EndOfReplay or Closed if there is none
   */
  LinkStatus
  next(LinkFrame& frame, std::chrono::milliseconds timeout) noexcept;

  /** \brief Requests an I-frame of a stream, as a decoder that fails needs it; not more
   * often than i_frame_request_interval allows. */
  void
  requestIFrame(const std::string& stream) noexcept;

  /** \brief Takes no further frames; next() returns those that wait already. */
  void
  stop() noexcept;

  SubscriberStatistics
  statistics() const;

  /** \brief True while there is a connection to the server. */
  bool
  isConnected() const noexcept;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** \brief How much of a site's frames a server keeps. */
struct KeepSettings {
  /** \brief Frames are deleted when they are older; 0: none is, for its age. Without a
   * value the server's limit stays, and is 24 hours where it has kept nothing. */
  std::optional<std::chrono::seconds> max_age;

  /** \brief The oldest are deleted when all are larger, bytes; 0: no limit of their own.
   * Without a value the server's limit stays, and there is none where it has kept
   * nothing. */
  std::optional<std::uint64_t> max_bytes;
};

/** \brief What a server keeps of a site's frames. */
struct KeptFrames {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
  Time first_time{0};                  ///< arrival of the oldest one
  std::uint64_t messages_deleted = 0;  ///< for the limits, by this call
  std::chrono::nanoseconds max_age{0}; ///< 0: no limit
  std::uint64_t max_bytes = 0;         ///< 0: no limit
};

/** \brief Makes the server keep the frames of a site, in a stream of JetStream with the
 * site's name, or changes how much of them. JetStream must be on in the server's
 * configuration.
 * \param[out] kept what it keeps now
 */
PCL_EXT_LINK_EXPORT LinkStatus
keepFrames(const LinkSettings& link,
           const KeepSettings& keep,
           KeptFrames& kept) noexcept;

/** \brief A stream that a server has. */
struct SiteStream {
  std::string site;
  std::string name;
  std::optional<unsigned int> partition; ///< where the server divides the streams
};

/** \brief Names streams whose frames come to a server now, of all sites that the user may
 * subscribe to. Listens to some thousand messages at most, so that of more streams some
 * are left out.
 * \param[in] link its site is listened to also where others are not permitted
 * \param[in] duration how long to listen
 * \param[out] streams ascending by site, name and partition
 */
PCL_EXT_LINK_EXPORT LinkStatus
liveStreams(const LinkSettings& link,
            std::chrono::milliseconds duration,
            std::vector<SiteStream>& streams) noexcept;

/** \brief Names the streams of a site whose frames a server keeps, see keepFrames().
 * \param[out] streams ascending by name and partition
 */
PCL_EXT_LINK_EXPORT LinkStatus
keptStreams(const LinkSettings& link, std::vector<SiteStream>& streams) noexcept;

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::link

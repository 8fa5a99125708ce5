// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Subjects of NATS: SITE.STREAM.frames, after which the server may put the
 * number of a partition, SITE.STREAM.requests for I-frames, and SITE.PUBLISHER.echo, by
 * which a publisher learns what the server has.
 */
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief Longest name of a stream. All its bytes may take three in a subject, and a
 * server takes 4096 for subject and sizes. */
constexpr std::size_t longest_stream_name = 1000;

/** \brief Text without characters that have a meaning in subjects, headers or
 * wildcards: all bytes but letters, digits and - _ / become % and two hexadecimal
 * digits. */
std::string
escaped(std::string_view text);

/** \brief The text that escaped() made this of; nothing if it made none. */
std::optional<std::string>
unescaped(std::string_view escaped_text);

/** \brief The subject of a stream's frames. */
std::string
framesSubject(const std::string& site, const std::string& stream);

/** \brief The subject of requests for a stream's I-frames. */
std::string
requestsSubject(const std::string& site, const std::string& stream);

/** \brief The subject of what a publisher sends to itself. */
std::string
echoSubject(const std::string& site, std::uint64_t publisher);

/** \brief A subject of frames. */
struct FramesSubject {
  std::string stream;
  std::optional<unsigned int> partition;
};

/** \brief Takes a subject of frames apart; nothing if it is none of this site. */
std::optional<FramesSubject>
parseFramesSubject(const std::string& site, std::string_view subject);

/** \brief The stream of a subject of frames, of any site; nothing if it is none. */
std::optional<SiteStream>
siteStreamOf(std::string_view subject);

inline bool
operator<(const SiteStream& a, const SiteStream& b)
{
  return std::tie(a.site, a.name, a.partition) < std::tie(b.site, b.name, b.partition);
}

} // namespace pcl_ext::PCL_EXT_ABI::link

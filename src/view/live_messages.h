// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The texts and the head of frames that servers and viewers exchange;
 * doc/viewing.md.
 */
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief Name of the protocol in Sec-WebSocket-Protocol. */
constexpr char live_protocol[] = "pcl_ext.live.v1";

/** \brief A stream as viewers know it; its id is its place in the list. */
struct LiveStream {
  std::string name;
  std::map<std::string, std::string> metadata;
};

/** \brief A file of a recording as the page knows it. */
struct ListedFile {
  std::string name;
  std::string url;
  std::uint64_t size = 0;
};

/** \brief What stands before a frame: stream, flags, time. */
using FrameHead = std::array<std::uint8_t, 16>;

/** \brief Flag: frames of the stream were skipped before this one. */
constexpr std::uint32_t skipped_before = 1;

/** \brief Flag: the frame was published before the viewer came, or asked for it. */
constexpr std::uint32_t published_before = 2;

FrameHead
frameHead(std::size_t stream, std::uint32_t flags, std::chrono::nanoseconds time);

std::string
streamsMessage(const std::vector<LiveStream>& streams);

/** \brief The message on how fresh the streams are.
 * \param[in] problem why frames may be missing, for people; empty: none is known
 * \param[in] ages time since the last frame of each stream; none: it has had none
 */
std::string
stateMessage(const std::string& problem,
             const std::vector<std::optional<std::chrono::milliseconds>>& ages);

/** \brief The message after the last frame. */
std::string
endMessage();

/** \brief The stream of which a viewer's message asks for an I-frame; nothing if that
 * is another message, or none. */
std::optional<std::size_t>
requestedIFrame(const std::string& message);

/** \brief What the page gets as api/source.json. */
std::string
liveSource(const std::string& name);
std::string
recordingSource(const std::string& name, const std::vector<ListedFile>& files);

} // namespace pcl_ext::PCL_EXT_ABI::view

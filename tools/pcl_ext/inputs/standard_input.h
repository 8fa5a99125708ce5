// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/system_files.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace pcl_ext::tools {

/** \brief A path at which an input can be read at any place and more than once: its
 * own; for the standard input, which is "-", and for a pipe that of a copy without a
 * name, which is there until the program ends.
 * \throws std::runtime_error if it cannot be copied
 */
std::string
pathOfInput(const std::string& path);

/** \brief An MCAP file that comes through a pipe or a socket can be read as it comes.
 * \return the descriptor of such an input, of which 8 bytes were read; nothing for
 * other inputs
 * \throws std::runtime_error if it cannot be read
 */
std::optional<recording::Descriptor>
mcapPipeOf(const std::string& path);

/** \brief True if a pipe has no bytes at the moment, nor soon, and has not ended. */
bool
mustWaitFor(int descriptor);

/** \brief Waits for bytes of a pipe, and reads up to so many.
 * \return their number; 0 at the end, or if the program is interrupted
 * \throws std::runtime_error if reading fails
 */
std::size_t
readPipe(int descriptor, std::uint8_t* bytes, std::size_t count);

/** \brief The path of an input for messages. */
std::string
shownName(const std::string& path);

/** \brief The name that an input has in names of streams: that of its file without
 * extension, "stdin" for the standard input. */
std::string
streamNameOfInput(const std::string& path);

/** \brief A path, or a message with paths, for people: inputs that were copied have the
 * names that the user gave.
 */
std::string
shown(std::string text);

} // namespace pcl_ext::tools

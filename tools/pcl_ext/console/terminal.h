// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace pcl_ext::tools {

/** \file
 * \brief What systems do differently with terminals and the standard streams.
 */

enum class StandardStream { Input, Output, Error };

/** \brief True if a stream is a terminal, which understands escape sequences then. */
bool
isTerminal(StandardStream stream);

/** \brief Columns of the terminal of standard error; 0 if they are not known. */
std::size_t
terminalWidth();

/** \brief True if nobody reads the standard output any more. Windows does not tell. */
bool
isReaderGone();

} // namespace pcl_ext::tools

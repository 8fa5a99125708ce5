// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "console/console.h"
#include "inputs/stream_metadata.h"
#include "inputs/viewpoints.h"
#include "options/encoding_options.h"
#include "streams/encoded_stream.h"

#include <string>

namespace pcl_ext::tools {

/** \brief Prints what is to be known of a stream that was encoded.
 * \return false if nothing of it was encoded, points are outside the grid of voxels, or
 * clouds of one coordinate frame have the name of another
 */
bool
remarkOnStream(Console& console,
               const std::string& name,
               const EncodedStreamReport& report);

/** \brief Adds the viewpoints of the files of a stream to its metadata, or says why they
 * are left out.
 * \param[in] has_metadata the output has room for them
 */
void
addViewpoints(Console& console,
              const EncodingOptions& options,
              const std::string& name,
              const Viewpoints& viewpoints,
              bool has_metadata,
              StreamMetadata& metadata);

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/node_parameters.h>

#include "nodes/parameter_access.h"
#include "stream/encoder_setting.h"

#include <vector>

// The parameters that are settings of the codec.

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Appends the parameters for the settings of a table that nodes offer. */
PCL_EXT_EXPORT void
describeCodec(const io::EncoderSettingTable& table,
              std::vector<ParameterDescription>& parameters);

/** \brief Reads the settings of a table that nodes offer.
 * \return Ok; or InvalidSettings for a text that cannot be read
 */
PCL_EXT_EXPORT io::CompressionStatus
readCodec(const io::EncoderSettingTable& table,
          const ParameterAccess& access,
          io::EncoderSettings& settings);

} // namespace pcl_ext::PCL_EXT_ABI::nodes

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/status.h>

#include "stream/encoder_setting.h"

#include <CLI/App.hpp>

#include <string>

namespace pcl_ext::tools {

/** \brief Adds the options of a group of settings, with their present values as defaults.
 * \param[in,out] settings changed by the options
 */
void
addSettingOptions(CLI::App& app,
                  const io::EncoderSettingTable& table,
                  io::OptionGroup group,
                  io::EncoderSettings& settings);

/** \brief The option of a setting, "--resolution"; the id if it has none. */
std::string
optionOf(const std::string& id);

/** \brief The parameter of the nodes for an option, "coarsen_wide_clouds" for
 * "--coarsen"; its own words if it is of no setting. */
std::string
parameterNameOf(const std::string& option);

/** \brief The message of a status with the names of options. */
template <typename CodeT>
std::string
messageOf(const Status<CodeT>& status)
{
  return status.text().with(optionOf);
}

} // namespace pcl_ext::tools

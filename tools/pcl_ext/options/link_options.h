// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/link_settings.h>

#include <CLI/App.hpp>

namespace pcl_ext::tools {

/** \brief Adds which NATS server, as whom and for which site. Each has a variable of the
 * environment, too; password and token have that alone, as others see command lines. */
void
addLinkOptions(CLI::App& app, link::LinkSettings& settings);

/** \brief Takes password and token from the environment, and checks all.
 * \throws UsageError
 */
void
completeLinkSettings(link::LinkSettings& settings);

} // namespace pcl_ext::tools

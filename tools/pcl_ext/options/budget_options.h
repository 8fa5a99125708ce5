// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <CLI/App.hpp>

namespace pcl_ext {
namespace tools {

/** \brief Adds --max-rate and what else is set of the budget of a stream. */
void
addBudgetOptions(CLI::App& app, io::RateSettings& settings);

/** \brief Refuses options that have no effect without a limit.
 * \throws UsageError
 */
void
checkBudgetOptions(const CLI::App& app, const io::RateSettings& settings);

} // namespace tools
} // namespace pcl_ext

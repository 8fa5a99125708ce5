// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The subcommands of the program. Each function adds one with its options; it
 * returns what runs it, which returns the exit status.
 */
#pragma once

#include <CLI/App.hpp>

#include <functional>

namespace pcl_ext::tools {

using Run = std::function<int()>;

Run
addEncode(CLI::App& app);
Run
addDecode(CLI::App& app);
Run
addInfo(CLI::App& app);
Run
addVerify(CLI::App& app);
Run
addCut(CLI::App& app);
Run
addMerge(CLI::App& app);
Run
addView(CLI::App& app);
Run
addSend(CLI::App& app);
Run
addReceive(CLI::App& app);
Run
addKeep(CLI::App& app);
Run
addAdvise(CLI::App& app);
Run
addBenchmark(CLI::App& app);
Run
addDemo(CLI::App& app);

} // namespace pcl_ext::tools

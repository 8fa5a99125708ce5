// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace pcl_ext::tools {

/** \brief From now on SIGINT, SIGTERM, SIGHUP and SIGXCPU (on Windows Ctrl-C and
 * Ctrl-Break) set a flag instead of ending
 * the program; one that comes two seconds later ends it. A pipe whose reader is gone,
 * and a file that may not become as large (ulimit -f), are errors of writing. */
void
catchInterruptions();

/** \brief True if the user wants the program to end; loops over frames ask. */
bool
isInterrupted();

} // namespace pcl_ext::tools

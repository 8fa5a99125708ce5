// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * How AddressSanitizer runs the fuzz targets.
 */

extern "C" const char*
__asan_default_options();

// A coder takes up to a few megabytes. A quarantine of the usual 256 MB would give
// every input new pages, which takes several times longer than the input. For longer
// stacks of allocations run the input again with ASAN_OPTIONS=malloc_context_size=30.
extern "C" const char*
__asan_default_options()
{
  return "quarantine_size_mb=8:malloc_context_size=2";
}

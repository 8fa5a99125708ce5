// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>

// WebAssembly without threads has no std::async.
#if !defined(__wasm__)
#include <future>
#include <vector>
#endif

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief A part of a cloud has at least so many points: of smaller ones starting a
 * thread costs more than it saves. */
constexpr std::size_t least_points_per_part = std::size_t{1} << 15;

/** \brief Calls work(0) to work(count - 1), at the same time in as many threads, one of
 * which is the caller's, and returns when all have ended. What one throws is passed
 * on. */
template <typename WorkT>
void
runAtOnce(std::size_t count, const WorkT& work)
{
#if defined(__wasm__)
  for (std::size_t i = 0; i < count; ++i)
    work(i);
#else
  std::vector<std::future<void>> others; // their destructors wait
  others.reserve(count - 1);
  // Where no thread can be started, the call is made when it is waited for.
  for (std::size_t i = 1; i < count; ++i)
    others.push_back(std::async(std::launch::async | std::launch::deferred,
                                [&work, i] { work(i); }));
  work(0);
  for (std::future<void>& other : others)
    other.get();
#endif
}

} // namespace pcl_ext::PCL_EXT_ABI::io

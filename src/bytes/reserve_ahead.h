// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Reserves capacity for at least this many elements. If that needs an
 * allocation, a quarter more is reserved, so that the growing frames of a stream soon
 * need none. */
template <class Vector>
void
reserveAhead(Vector& vector, std::size_t size)
{
  if (vector.capacity() < size)
    vector.reserve(size + size / 4 + 4);
}

/** \brief Resizes a vector that is shorter than this, to a quarter more, 2^16 elements
 * more at most. For vectors that are used up to a count, as resizing them down would
 * initialise their elements again. */
template <class Vector>
void
ensureSize(Vector& vector, std::size_t size)
{
  if (vector.size() < size)
    vector.resize(size + std::min(size / 4, std::size_t{1} << 16));
}

} // namespace pcl_ext::PCL_EXT_ABI::io

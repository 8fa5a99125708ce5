// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>

namespace pcl_ext {
namespace io {

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

} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "voxels/child_masks.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

constexpr unsigned int all_ones = ~0u;

/** \brief Rank of one of some children: the likely ones come first, both groups
 * ascending.
 *
 *     child       0  1  2  3  4  5  6  7
 *     children    x  x  .  x  x  .  x  x
 *     likely      .  x  .  .  x  .  .  .
 *     rank        2  0  .  3  1  .  4  5
 *
 * \param[in] likely some of the children
 * \param[in] children mask of them
 * \param[in] child its bit in the mask
 */
inline unsigned int
rankOf(unsigned int likely, unsigned int children, unsigned int child)
{
  const unsigned int is_unlikely = all_ones * ((child & likely) == 0 ? 1 : 0);
  return (child_masks.count[likely] & is_unlikely) +
         child_masks.count[(likely ^ (children & is_unlikely)) & (child - 1) & 0xff];
}

/** \brief The child with a rank; see rankOf(). */
inline unsigned int
childOfRank(unsigned int likely, unsigned int children, unsigned int rank)
{
  const unsigned int count = child_masks.count[likely];
  const unsigned int is_unlikely = ~(0u - ((rank - count) >> 31));
  return child_masks
      .children[likely ^ (children & is_unlikely)][(rank - (count & is_unlikely)) % 8];
}

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

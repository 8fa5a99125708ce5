// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/slot_table.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

/** \brief Fixed probabilities of the values of a byte. */
using ByteTable = SlotTable<256>;

/** \brief The probability of the table for a probability, of which 2^16 is 1: in units
 * of 2^-7, in coarser steps in the middle. */
constexpr unsigned int
tableProbability(unsigned int probability)
{
  const unsigned int fine = probability >> 9;
  return fine < 1 ? 1 : fine >= 8 && fine < 120 ? fine / 4 * 4 + 2 : fine;
}

/** \brief Table of the occupancy pattern of eight voxels that are occupied
 * independently with the same probability.
 * \param[in] probability 2^16 is 1
 */
const ByteTable&
occupancyTable(unsigned int probability);

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io

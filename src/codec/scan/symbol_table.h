// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/slot_table.h"

#include <array>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Probabilities of symbols, which are sent before the symbols. */
using SymbolTable = rans::SlotTable<80>;

using SymbolCounts = std::array<std::uint32_t, SymbolTable::symbol_count>;

/** \brief Slots for symbols in proportion to how often they occur: at least one for each
 * that does, and at least two symbols have some.
 * \param[in] counts their sum is below 2^32
 */
SymbolTable::Widths
widthsOf(const SymbolCounts& counts);

/** \brief Bits that symbols take with the table of their counts, and about what that
 * takes itself, in units of 2^-8. */
std::uint64_t
costOf(const SymbolCounts& counts);

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

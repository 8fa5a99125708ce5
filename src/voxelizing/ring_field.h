// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/point_view.h>

#include "codec/scan/scan_frame.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Usual names of the field of the rows of a spinning sensor; the first one that
 * there is counts. */
inline constexpr std::array<const char*, 3> ring_names = {"ring", "channel", "line"};

/** \brief The index of the field of rows. */
inline std::optional<std::size_t>
findRing(const std::vector<FieldDescription>& fields)
{
  for (const char* const name : ring_names)
    for (std::size_t i = 0; i < fields.size(); ++i)
      if (fields[i].name == name && fields[i].count == 1 && isField(fields[i]))
        return i;
  return std::nullopt;
}

/** \brief Reads rings of any type as numbers of rows. */
class RingReader {
public:
  /** \param[in] rings must live as long */
  explicit RingReader(const FieldView& rings) : rings_(rings), exact_(rings.description)
  {
    exact_.step = 0.0;
  }

  /** \brief The row of a point, or scan::most_side. */
  std::uint32_t
  row(std::size_t point) const
  {
    const auto* const first = static_cast<const unsigned char*>(rings_.first);
    const double ring =
        fieldValue(exact_, fieldNumber(exact_, first + point * rings_.stride));
    return ring >= 0.0 && ring < scan::most_side && ring == std::floor(ring)
               ? static_cast<std::uint32_t>(ring)
               : scan::most_side;
  }

private:
  const FieldView& rings_;
  FieldDescription exact_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

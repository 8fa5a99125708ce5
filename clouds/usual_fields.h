// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Fields as PCL has them, of files that have them otherwise.
 */
#pragma once

#include "clouds/channel_colours.h"
#include "clouds/long_integers.h"

#include <pcl/PCLPointCloud2.h>

#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief Gives the clouds of a stream the fields that PCL's programs look for:
 *
 * - X, Y, Z, RGB and RGBA become x, y, z, rgb and rgba, where there are none of these
 *   names;
 * - coordinates that are whole numbers, or of several types, become floats, doubles
 *   where floats cannot have each value;
 * - a packed colour, `rgb` or `rgba`, that is INT32 becomes UINT32: the same 32 bits;
 * - separate channels of a colour become one, see packColours(); a stream keeps the scale
 *   of its first colours;
 * - integers of 64 bits become doubles, or two numbers of 32 bits, see LongIntegers.
 */
class UsualFields {
public:
  explicit UsualFields(LongIntegers long_integers = {})
  : long_integers_(std::move(long_integers))
  {}

  /** \brief Gives them to the next cloud.
   * \param[in,out] cloud numbers in the order of this machine
   * \param[in] is_ply see packColours()
   * \return what the user is to know of it, a line each
   * \throws FieldRefusal see LongIntegers
   */
  std::vector<std::string>
  giveTo(pcl::PCLPointCloud2& cloud, bool is_ply);

private:
  LongIntegers long_integers_;
  ColourScale colours_;
};

/** \brief Gives coordinates and packed colours their usual names as UsualFields does.
 * \param[in,out] remarks is appended to
 */
void
nameUsually(pcl::PCLPointCloud2& cloud, std::vector<std::string>& remarks);

} // namespace clouds
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Fields as PCL has them, of files that have them otherwise.
 */
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief What becomes of fields of 64-bit integers, which frames have not: doubles if
 * these have all values of the cloud, else two uint32 with the same bits. */
struct LongIntegers {
  std::vector<std::string> with_step; ///< fields whose values are rounded to a step
  /** \brief Of several points one value is kept, which must be one of theirs: numbers of
   * 32 bits if these have all values, no doubles but for fields with a step. */
  bool one_of_several = false;
};

/** \brief Which values of separate channels are full, in all clouds of a stream; black
 * is 0. A cloud with a colour other than black sets what is not set. */
struct ColourScale {
  std::optional<double> colour; ///< 1, 255 or 65535
  std::optional<double> alpha;  ///< likewise
};

/** \brief A field cannot be used as the user wants it. */
class FieldRefusal : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/** \brief Gives a cloud the fields that PCL's programs look for:
 *
 * - X, Y, Z, RGB and RGBA become x, y, z, rgb and rgba, where there are none of these
 *   names;
 * - coordinates that are whole numbers, or of several types, become floats, doubles
 *   where floats cannot have each value;
 * - a packed colour, `rgb` or `rgba`, that is INT32 becomes UINT32: the same 32 bits;
 * - separate channels (red, green, blue, r, g, b, diffuse_red ..., in any case, with
 *   alpha or a) become `rgb`, or `rgba`, at the place of the first. Whole numbers up to
 *   255 are taken as they are, and up to 65535 as 16 bits; others from 0 to 1 as shares.
 *   Other values are no colours. A stream keeps the scale of its first colours, to which
 *   larger values are clamped. Where there is a packed colour, channels stay;
 * - integers of 64 bits become doubles, or two numbers of 32 bits: see LongIntegers.
 *
 * \param[in,out] cloud numbers in the order of this machine
 * \param[in] is_ply so that channels of 8 bits are the usual way of having colours
 * \param[in,out] scale of the stream's colours
 * \return what the user is to know of it, a line each
 * \throws FieldRefusal for a field that long_integers names and that needs two numbers
 */
std::vector<std::string>
makeUsual(pcl::PCLPointCloud2& cloud,
          bool is_ply,
          ColourScale& scale,
          const LongIntegers& long_integers = {});

/** \brief Gives coordinates and packed colours their usual names as makeUsual() does.
 * \param[in,out] remarks is appended to
 */
void
nameUsually(pcl::PCLPointCloud2& cloud, std::vector<std::string>& remarks);

/** \brief Packs separate channels of a colour as makeUsual() does.
 * \param[in,out] cloud its rows without gaps
 * \param[in,out] scale of the stream's colours
 * \param[in,out] remarks is appended to
 * \return what is to be said of values beyond the scale; empty: there are none
 */
std::string
packColours(pcl::PCLPointCloud2& cloud,
            bool is_ply,
            ColourScale& scale,
            std::vector<std::string>& remarks);

} // namespace clouds
} // namespace pcl_ext

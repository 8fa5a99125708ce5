#pragma once

#include <pcl_ext/export.h>

#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Lowest number of a level of a companded scale.
 *
 * The numbers 0..range fall into 2^bits levels, each of them at least one number. The
 * first levels are single numbers, with 8 levels or more the numbers 0..3 and where
 * level 4 begins; from there on they widen as the noise of a count does, with its root:
 *
 *     edge(4 + j) = 4 + j + (range - 3 - n) * j^2 / n^2,  n = 2^bits - 4,  j = 0..n
 *
 * rounded down. Four levels begin at 0, 1, 2, 4 and two at 0, 1. For counts from 1 on
 * (number = count - 1) the decisions "at least 2, 3, 4, 5 points" are thus exact with 3
 * bits or more, and "at least 2, 3, 5" with 2.
 *
 * \param[in] bits 1..15
 * \param[in] range the highest number, 2^bits..65535
 * \param[in] level 0..2^bits; the last one is none, and begins behind the range
 * \return a number, 0..range + 1, that ascends strictly with the level; it takes whole
 * numbers only, so that every machine has the same
 */
PCL_EXT_EXPORT std::uint32_t
compandedEdge(unsigned int bits, std::uint32_t range, std::uint32_t level);

/** \brief The number that a level stands for: the middle of its numbers, rounded down.
 *
 * It lies within the level, so that a decision "intensity >= threshold" is the same
 * before and after wherever the threshold is the edge of a level.
 *
 * \param[in] bits 1..15
 * \param[in] range the highest number, 2^bits..65535
 * \param[in] level 0..2^bits - 1
 */
PCL_EXT_EXPORT std::uint32_t
compandedMiddle(unsigned int bits, std::uint32_t range, std::uint32_t level);

} // namespace io
} // namespace pcl_ext

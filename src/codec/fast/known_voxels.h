#pragma once

#include "codec/fast/frame.h"
#include "codec/fast/history.h"
#include "codec/fast/models.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief For an encoder: sorts the voxels into blocks, and these into known and new
 * ones.
 * \param[in] history before the frame
 * \param[in] keys Morton keys of the voxels, ascending, at least one
 * \param[out] frame its occupied cells in known blocks, and the new blocks
 */
void
matchHistory(const History& history,
             const std::vector<std::uint64_t>& keys,
             Frame& frame);

/** \brief Number of a matched frame's voxels that are known. */
std::size_t
knownVoxelCount(const History& history, const Frame& frame);

/** \brief Codes which known voxels are occupied (doc/bitstream_fast.md, "Known voxels"),
 * bucket by bucket, and splits the buckets.
 *
 * A Coder is NibbleEncoder or NibbleDecoder.
 */
class KnownVoxels {
public:
  /** \brief Codes a frame.
   * \param[in] before the history before the frame
   * \param[out] after gets the buckets behind it
   * \param[in,out] frame in a decoder gets the occupied cells
   * \return false if the bytes end; never in an encoder
   */
  template <class Coder>
  bool
  code(Coder& coder,
       Models& models,
       const History& before,
       History& after,
       Frame& frame);

private:
  template <class Coder>
  bool
  splitBucket(Coder& coder,
              Models& models,
              unsigned int past,
              const History& before,
              History& after,
              Frame& frame);

  std::vector<std::uint8_t> occupancies_; // of a bucket, eight voxels in each
};

} // namespace fast
} // namespace io
} // namespace pcl_ext

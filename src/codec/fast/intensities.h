#pragma once

#include "codec/fast/entropy_coder.h"
#include "codec/fast/expected_intensities.h"
#include "codec/fast/frame.h"
#include "codec/fast/models.h"

#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Codes the intensity symbols of a frame (doc/bitstream_fast.md, "Symbols"): relative
 * to the statistics of the voxels, or plain if that is smaller. */
class Intensities {
public:
  /** \brief Codes the symbols, and updates models and statistics.
   * \param[in] frame its blocks and voxels
   * \param[in,out] statistics of the history, 64 a block
   * \param[in] bits of a symbol, 1..16
   * \param[in] symbols one for each voxel
   */
  void
  encode(NibbleEncoder& coder,
         Models& models,
         const Frame& frame,
         StatisticsTable& statistics,
         unsigned int bits,
         const std::vector<std::uint16_t>& symbols);

  /** \brief Inverse of encode().
   * \return false if the bytes are invalid; the caller then has to call restore()
   */
  bool
  decode(NibbleDecoder& coder,
         Models& models,
         const Frame& frame,
         StatisticsTable& statistics,
         unsigned int bits,
         std::vector<std::uint16_t>& symbols);

  /** \brief Restores the statistics to their state before the last frame. */
  void
  restore(const Frame& frame, StatisticsTable& statistics) const
  {
    expected_.restore(frame, statistics);
  }

private:
  void
  encodeExpected(NibbleEncoder& coder,
                 Models& models,
                 const Frame& frame,
                 StatisticsTable& statistics,
                 unsigned int bits,
                 const std::vector<std::uint16_t>& symbols);

  ExpectedIntensities expected_;
  Models models_before_; // encoder only: before this frame
};

} // namespace fast
} // namespace io
} // namespace pcl_ext

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

/** \brief Codes the intensity symbols of a frame (doc/bitstream_fast.md, "Symbols"): with
 * what the statistics of the voxels let expect, or plain where that is smaller. */
class Intensities {
public:
  /** \brief Codes the symbols; models and statistics learn them.
   * \param[in] frame its blocks and voxels
   * \param[in,out] statistics those of the history, 64 a block
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

  /** \brief The reverse.
   * \return false if the bytes are no such symbols; restore() undoes what was learnt
   */
  bool
  decode(NibbleDecoder& coder,
         Models& models,
         const Frame& frame,
         StatisticsTable& statistics,
         unsigned int bits,
         std::vector<std::uint16_t>& symbols);

  /** \brief Gives the statistics back as they were before the last frame. */
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
  Models models_before_; // an encoder's, before this frame
};

} // namespace fast
} // namespace io
} // namespace pcl_ext

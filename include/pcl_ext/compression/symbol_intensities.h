#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <vector>

namespace pcl_ext {
namespace io {

/** \brief The intensities of a companded scale's symbols, computed once for each scale,
 * not for each voxel. */
class PCL_EXT_EXPORT SymbolIntensities {
public:
  /** \brief IntensityScale::value of each symbol; costs next to nothing where the scale
   * is that of the last call.
   * \param[in] scale as isConsistent() asks
   * \return maxSymbol() + 1 values, until the next call; null for a linear scale, where a
   * product is as fast
   */
  const float*
  compandedValues(const IntensityScale& scale)
  {
    if (scale.companded_range == 0)
      return nullptr;
    if (scale != scale_)
      compute(scale);
    return values_.data();
  }

private:
  void
  compute(const IntensityScale& scale);

  IntensityScale scale_;      // linear: there are no values
  std::vector<float> values_; // by symbol
};

} // namespace io
} // namespace pcl_ext

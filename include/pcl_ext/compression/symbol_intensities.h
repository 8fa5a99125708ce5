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
  /** \brief Follows a stream's scale; costs next to nothing where it is the last one.
   * \param[in] scale as isConsistent() asks
   */
  void
  setScale(const IntensityScale& scale);

  /** \brief IntensityScale::value of each symbol; null for a linear scale, where a
   * product is as fast. */
  const float*
  compandedValues() const
  {
    return values_.empty() ? nullptr : values_.data();
  }

private:
  IntensityScale scale_;
  std::vector<float> values_; // by symbol
};

} // namespace io
} // namespace pcl_ext

#include <pcl_ext/compression/symbol_intensities.h>

namespace pcl_ext {
namespace io {

void
SymbolIntensities::compute(const IntensityScale& scale)
{
  // Should memory fail, no scale has another's values.
  scale_ = IntensityScale();
  values_.clear();
  for (std::uint32_t symbol = 0; symbol <= scale.maxSymbol(); ++symbol)
    values_.push_back(scale.value(static_cast<std::uint16_t>(symbol)));
  scale_ = scale;
}

} // namespace io
} // namespace pcl_ext

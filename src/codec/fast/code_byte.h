#pragma once

#include "codec/fast/models.h"

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Codes a byte as two nibbles. */
template <class Coder, std::size_t contexts>
unsigned int
codeByte(Coder& coder,
         ByteModels<contexts>& models,
         unsigned int context,
         unsigned int byte)
{
  const unsigned int low = coder.code(models.low[context], byte & 15);
  return low | coder.code(models.high[low], byte >> 4) << 4;
}

} // namespace fast
} // namespace io
} // namespace pcl_ext

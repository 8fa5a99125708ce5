#include "codec/fast/models.h"

namespace pcl_ext {
namespace io {
namespace fast {

Models::Models()
{
  for (unsigned int past = 1; past < voxel_past::count; ++past)
    known_probability[past] =
        static_cast<std::uint16_t>(voxel_past::firstProbability(past));
}

const Models&
firstModels()
{
  static const Models models;
  return models;
}

} // namespace fast
} // namespace io
} // namespace pcl_ext

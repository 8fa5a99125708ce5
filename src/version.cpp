#include <pcl_ext/version.h>

namespace pcl_ext {

const char*
version() noexcept
{
  return PCL_EXT_VERSION_TEXT;
}

} // namespace pcl_ext

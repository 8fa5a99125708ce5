#include "inputs/cloud_input.h"

#include <stdexcept>

namespace pcl_ext {
namespace tools {

std::unique_ptr<CloudInput>
openRos1Bag(const std::string& path, const InputOptions& /* options */)
{
  throw std::runtime_error("'" + path +
                           "' is a bag of ROS 1, and this program was built without "
                           "librosbag-storage: convert the bag to MCAP, or build where "
                           "librosbag-storage-dev is installed");
}

} // namespace tools
} // namespace pcl_ext

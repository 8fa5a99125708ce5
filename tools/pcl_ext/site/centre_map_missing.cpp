#include "console/exit_status.h"
#include "site/centre_map.h"

namespace pcl_ext {
namespace tools {

class CentreMap::Implementation {};

CentreMap::CentreMap(const CentreMapOptions& options,
                     double /* resolution */,
                     Console& /* console */)
{
  if (!options.path.empty())
    throw UsageError("this program was built without OctoMap, which --map needs");
}

CentreMap::~CentreMap() = default;

void
CentreMap::addStream(const std::string& /* name */,
                     const StreamMetadata& /* metadata */)
{}

void
CentreMap::update(const nodes::CentralNode& /* node */, nodes::Time /* time */)
{}

void
CentreMap::finish(const nodes::CentralNode& /* node */)
{}

} // namespace tools
} // namespace pcl_ext

#include "commands/commands.h"

#include <stdexcept>

namespace pcl_ext {
namespace tools {

Run
addView(CLI::App& app)
{
  app.allow_extras();
  return []() -> int {
    throw std::runtime_error("this program was built without Boost.Beast and "
                             "nlohmann_json, which the viewer's server needs");
  };
}

} // namespace tools
} // namespace pcl_ext

#include "commands/commands.h"

#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

Run
withoutLink(CLI::App& app)
{
  app.allow_extras();
  return []() -> int {
    throw std::runtime_error(
        "this program was built without libnats, NATS's client, which the link needs");
  };
}

} // namespace

Run
addSend(CLI::App& app)
{
  return withoutLink(app);
}

Run
addReceive(CLI::App& app)
{
  return withoutLink(app);
}

Run
addKeep(CLI::App& app)
{
  return withoutLink(app);
}

} // namespace tools
} // namespace pcl_ext

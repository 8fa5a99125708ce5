#include "site/site_view.h"

namespace pcl_ext {
namespace tools {

void
addSiteViewOptions(CLI::App& /* app */, SiteViewOptions& /* options */)
{}

std::unique_ptr<FrameTaker>
makeSiteView(const SiteViewOptions& /* options */,
             const std::string& /* name */,
             std::function<void(const std::string& stream)> /* request_i_frame */,
             std::function<std::string()> /* metrics */,
             Console& /* console */)
{
  return nullptr;
}

void
addMetricsOptions(CLI::App& /* app */, MetricsOptions& /* options */)
{}

std::shared_ptr<void>
serveMetrics(const MetricsOptions& /* options */,
             std::function<std::string()> /* metrics */)
{
  return nullptr;
}

} // namespace tools
} // namespace pcl_ext

/** \file
 * \brief In place of stream_view.cpp where the library's component view is not installed.
 */
#include "stream_view.h"

#include <stdexcept>

namespace pcl_ext_ros {

class StreamView::Implementation {};

StreamView::StreamView(const pcl_ext::nodes::ParameterValues&,
                       const std::function<void(const std::string&)>&,
                       const std::function<std::string()>&)
{
  throw std::runtime_error(
      "view_port: this package was built without the component view of pcl_ext");
}

StreamView::~StreamView() = default;

void
StreamView::show(const std::string&,
                 pcl_ext::nodes::Time,
                 const std::vector<std::uint8_t>&)
{}

std::string
StreamView::url() const
{
  return {};
}

bool
StreamView::isLoopback() const
{
  return true;
}

} // namespace pcl_ext_ros

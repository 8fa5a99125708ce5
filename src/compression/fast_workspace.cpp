#include "fast_workspace.h"

#include <utility>

namespace pcl_ext {
namespace io {

std::shared_ptr<FastWorkspacePool>
FastWorkspacePool::shared()
{
  static std::mutex mutex;
  static std::weak_ptr<FastWorkspacePool> current;
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<FastWorkspacePool> pool = current.lock();
  if (!pool) {
    pool = std::make_shared<FastWorkspacePool>();
    current = pool;
  }
  return pool;
}

std::unique_ptr<FastWorkspace>
FastWorkspacePool::take()
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (std::unique_ptr<FastWorkspace> workspace = std::move(first_)) {
      first_ = std::move(workspace->next);
      return workspace;
    }
  }
  return std::make_unique<FastWorkspace>();
}

void
FastWorkspacePool::giveBack(std::unique_ptr<FastWorkspace> workspace)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  workspace->next = std::move(first_);
  first_ = std::move(workspace);
}

} // namespace io
} // namespace pcl_ext

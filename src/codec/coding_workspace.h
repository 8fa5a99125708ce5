#pragma once

#include "codec/fast/workspace.h"
#include "voxels/memory_rule.h"

#include <cstddef>
#include <memory>

namespace pcl_ext {
namespace io {

/** \brief Memory for a frame while it is coded; see CodingMemory. */
class CodingWorkspace {
public:
  /** \brief That of effort fast. */
  fast::Workspace&
  fast()
  {
    if (!fast_)
      fast_ = std::make_unique<fast::Workspace>();
    return *fast_;
  }

  /** \brief Ends a frame; gives memory back that frames of long ago needed, and these do
   * not.
   * \param[in] needed by the frame, in voxels and bytes
   * \param[in] taken for it, likewise
   */
  void
  endFrame(std::size_t needed, std::size_t taken)
  {
    if (memory_rule_.shouldGiveBack(needed, taken))
      fast_.reset();
  }

private:
  std::unique_ptr<fast::Workspace> fast_;
  MemoryRule memory_rule_;
};

} // namespace io
} // namespace pcl_ext

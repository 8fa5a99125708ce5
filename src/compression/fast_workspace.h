#pragma once

#include "fast_frame.h"
#include "fast_history.h"
#include "fast_models.h"
#include "fast_occupancy.h"
#include "fast_symbols.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief What the fast coder needs while a frame is in its hands: nothing in here
 * outlives the frame but memory. */
struct FastWorkspace {
  FastFrame frame;
  FastOccupancy occupancy;
  FastSymbols symbols;
  /** \brief A decoder's, as the frame makes them; they change places with the coder's when
   * the frame is whole. */
  std::unique_ptr<FastModels> models = std::make_unique<FastModels>();
  /** \brief The history behind the frame. In a P-frame its moments are those of the
   * coder. */
  FastHistory next_history;
  std::vector<std::uint32_t> steps;
  std::vector<std::uint16_t> words;
  std::vector<std::uint8_t> bytes;

  std::unique_ptr<FastWorkspace> next; ///< in the pool
};

/** \brief The workspaces of all fast coders that live, as many as frames were ever in
 * work at once.
 *
 * A computer with hundreds of streams takes their frames in turn. What a coder last
 * touched a round ago is no longer in the caches, so it should be little: the workspace
 * is the one that the frame before has just left. Safe for use by several threads.
 */
class FastWorkspacePool {
public:
  /** \brief The one of this program; without a coder that holds it there is none. */
  static std::shared_ptr<FastWorkspacePool>
  shared();

  /** \brief The workspace that was given back last, or a new one. */
  std::unique_ptr<FastWorkspace>
  take();

  void
  giveBack(std::unique_ptr<FastWorkspace> workspace);

private:
  std::mutex mutex_;
  std::unique_ptr<FastWorkspace> first_;
};

} // namespace io
} // namespace pcl_ext

#pragma once

#include "fast_frame.h"
#include "fast_history.h"
#include "fast_models.h"
#include "fast_occupancy.h"
#include "fast_symbols.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief What the fast coder needs while it codes a frame, and what the frame teaches
 * until it is learnt. Nothing in here outlives the frame but memory. */
struct FastWorkspace {
  FastFrame frame;
  FastOccupancy occupancy;
  FastSymbols symbols;
  /** \brief A decoder's, as the frame makes them; they change places with the coder's when
   * the frame is learnt. */
  std::unique_ptr<FastModels> models = std::make_unique<FastModels>();
  /** \brief The history behind the frame. In a P-frame its moments are those of the
   * coder. */
  FastHistory next_history;
  std::vector<std::uint32_t> steps;
  std::vector<std::uint16_t> words;
  std::vector<std::uint8_t> bytes;
};

} // namespace io
} // namespace pcl_ext

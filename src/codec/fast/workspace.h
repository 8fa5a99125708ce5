#pragma once

#include "codec/fast/frame.h"
#include "codec/fast/history.h"
#include "codec/fast/intensities.h"
#include "codec/fast/models.h"
#include "codec/fast/occupancy.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief What the fast coder needs while it codes a frame, and what the frame teaches
 * until it is learnt. Nothing in here outlives the frame but memory. */
struct Workspace {
  Frame frame;
  Occupancy occupancy;
  Intensities symbols;
  /** \brief A decoder's, as the frame makes them; they change places with the coder's when
   * the frame is learnt. */
  std::unique_ptr<Models> models = std::make_unique<Models>();
  /** \brief The history behind the frame. In a P-frame its moments are those of the
   * coder. */
  History next_history;
  std::vector<std::uint32_t> steps;
  std::vector<std::uint16_t> words;
  std::vector<std::uint8_t> bytes;
};

} // namespace fast
} // namespace io
} // namespace pcl_ext

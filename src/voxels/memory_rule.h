#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace pcl_ext {
namespace io {

/** \brief Tells when memory that is reused from frame to frame has become far too large
 * for the stream and should be given back: one huge frame must not cost its memory for
 * ever, and frames whose sizes go up and down must not cost an allocation each.
 *
 * It counts in whatever unit it is told, bytes or elements; the floor has the same unit.
 */
class MemoryRule {
public:
  /** \brief So many frames must do with less before memory is given back. */
  static constexpr std::size_t frames = 8;

  /** \brief Memory of so many times what they needed stays. */
  static constexpr std::size_t factor = 4;

  /** \brief Less is not worth giving back, bytes. */
  static constexpr std::size_t default_floor = std::size_t{1} << 16;

  /** \param[in] floor what needed no more than this is never given back */
  explicit MemoryRule(std::size_t floor = default_floor) : floor_(floor) {}

  /** \brief Takes what the current frame needed. Call it once a frame, also of frames
   * that failed, with what they needed until then.
   * \param[in] needed by the current frame
   * \param[in] taken for it, if that may be more, as for one that failed
   * \return true if memory made for more than `factor` times what any of the last
   * `frames` frames needed, this one included, should be given back now
   */
  bool
  shouldGiveBack(std::size_t needed, std::size_t taken = 0)
  {
    last_[next_] = needed;
    next_ = (next_ + 1) % frames;
    most_ = std::max({most_, needed, taken});
    const std::size_t most_of_last = *std::max_element(last_.begin(), last_.end());
    // Divided, as a product could be too large to hold.
    if (most_ <= floor_ || (most_ - 1) / factor < most_of_last)
      return false;
    most_ = most_of_last;
    return true;
  }

private:
  std::size_t floor_;
  std::array<std::size_t, frames> last_{}; // what the last frames needed
  std::size_t next_ = 0;                   // the oldest of them
  std::size_t most_ = 0; // that was needed since memory was last given back
};

} // namespace io
} // namespace pcl_ext

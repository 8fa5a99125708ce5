#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Decides for an encoder whether the next frame uses the history, by the sizes of
 * the last frames: that of a moving sensor may cost more bytes than it saves. Integers only,
 * so that the same frames have the same bytes on every machine. */
class HistoryUse {
public:
  /** \brief False if the history has so few of a frame's voxels that it costs more bytes
   * than it saves.
   * \param[in] known number of its voxels that the history has
   * \param[in] voxels of the frame
   */
  static constexpr bool
  knowsEnough(std::size_t known, std::size_t voxels)
  {
    return 2 * known >= voxels;
  }

  /** \brief False if the next frame should do without the history. */
  bool
  isUseful() const
  {
    return frames_without_ == 0;
  }

  /** \brief Takes a frame into account.
   * \param[in] has_used_history whether it was coded with the history
   * \param[in] voxels of the frame
   * \param[in] bytes of the frame, or of one like it without the history
   */
  void
  add(bool has_used_history, std::size_t voxels, std::size_t bytes)
  {
    if (!has_used_history) {
      without_history_ = {voxels, bytes};
      frames_with_ = 0;
      frames_without_ -= frames_without_ > 0 ? 1 : 0;
      return;
    }
    // A young history of a noisy stream may cost a little until it pays.
    constexpr unsigned int young = 2;
    const bool is_young = ++frames_with_ <= young && pause_ == 0;
    const std::size_t most =
        without_history_.bytes + (is_young ? without_history_.bytes / 16 : 0);
    // The headers of small frames say more than their voxels.
    constexpr std::size_t least_voxels = 256;
    const bool is_useless =
        voxels >= least_voxels &&
        std::uint64_t{bytes} * without_history_.voxels > std::uint64_t{most} * voxels;
    // It is tried again after ever more frames, as long as it gains nothing.
    constexpr unsigned int first_pause = 7;
    constexpr unsigned int longest_pause = 63;
    pause_ = is_useless ? std::clamp(2 * pause_ + 1, first_pause, longest_pause) : 0;
    frames_without_ = pause_;
  }

private:
  struct Size {
    std::size_t voxels = 0;
    std::size_t bytes = 0;
  };

  Size without_history_;            // the last such frame
  std::size_t frames_with_ = 0;     // since then
  unsigned int pause_ = 0;          // frames until the history is tried again
  unsigned int frames_without_ = 0; // of these, those that are left
};

} // namespace io
} // namespace pcl_ext

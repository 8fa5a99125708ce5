#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Decides for an encoder which frames use the history, by the sizes of frames:
 * that of a moving sensor may cost more bytes than it saves. Integers only, so that the
 * same frames have the same bytes on every machine. */
class HistoryUse {
public:
  /** \brief False if the next frame should do without the history. */
  bool
  isUseful() const
  {
    return frames_until_retry_ == 0;
  }

  /** \brief True if a frame with the history takes more bytes a voxel than the last one
   * without it, so that it should be encoded without, too.
   * \param[in] voxels of the frame
   * \param[in] bytes of the frame
   * \param[in] has_points the frame has numbers of points: a young history may cost
   * more
   */
  bool
  isDoubtful(std::size_t voxels, std::size_t bytes, bool has_points = false) const
  {
    // The first P-frame of noisy voxels takes 3 to 8 % more bytes than an I-frame, the
    // tenth 13 to 17 % fewer.
    const std::size_t share = has_points ? 8 : default_share;
    // The headers of small frames say more than their voxels.
    constexpr std::size_t least_voxels = 256;
    return voxels >= least_voxels &&
           std::uint64_t{bytes} * without_history_.voxels >
               std::uint64_t{most(without_history_.bytes, share)} * voxels;
  }

  /** \brief True if a frame should use the history.
   * \param[in] bytes of the frame with it
   * \param[in] bytes_without of the same frame
   */
  bool
  isWorth(std::size_t bytes, std::size_t bytes_without) const
  {
    return bytes <= most(bytes_without, default_share);
  }

  /** \brief Notes what a frame takes without the history. */
  void
  measure(std::size_t voxels, std::size_t bytes)
  {
    without_history_ = {voxels, bytes};
  }

  /** \brief A frame used the history. */
  void
  addWith()
  {
    if (++frames_with_ > young)
      pause_ = 0;
  }

  /** \brief A frame did not use the history, or was an I-frame.
   * \param[in] was_tried it was not worth its bytes: it is tried again after ever more
   * frames
   */
  void
  addWithout(bool was_tried)
  {
    frames_with_ = 0;
    frames_until_retry_ -= frames_until_retry_ > 0 ? 1 : 0;
    if (!was_tried)
      return;
    constexpr unsigned int first_pause = 7;
    constexpr unsigned int longest_pause = 63;
    pause_ = std::clamp(2 * pause_ + 1, first_pause, longest_pause);
    frames_until_retry_ = pause_;
  }

private:
  struct Size {
    std::size_t voxels = 0;
    std::size_t bytes = 0;
  };

  /** \brief A young history of a noisy stream may cost a little until it pays: one part
   * in `share` of the bytes. */
  std::size_t
  most(std::size_t bytes_without, std::size_t share) const
  {
    return bytes_without + (frames_with_ < young ? bytes_without / share : 0);
  }

  static constexpr unsigned int young = 2; // frames
  static constexpr std::size_t default_share = 32;

  Size without_history_;                // of the last frame that was measured
  unsigned int frames_with_ = 0;        // since the last one without
  unsigned int pause_ = 0;              // frames until the history is tried again
  unsigned int frames_until_retry_ = 0; // of these, those that are left
};

} // namespace io
} // namespace pcl_ext

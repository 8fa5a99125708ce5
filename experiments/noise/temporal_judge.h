/** \file
 * \brief How well the shown voxels of a filtered stream agree with the truth.
 */
#pragma once

#include "measuring/samples.h"
#include "nearby_voxels.h"
#include "simulator/labelled_stream.h"
#include "true_view.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief The true surfaces of a stream, up to the frame that was added last. A voxel of
 * a surface is one whose truth is not Noise; near means within one voxel. */
class SurfaceHistory {
public:
  /** \brief A surface counts as new if none was near in as many frames before. */
  static constexpr std::int64_t frames_without = 5;
  /** \brief Neighbours of a surface that a voxel of a new one has, at least. */
  static constexpr std::size_t least_neighbours = 3;
  /** \brief A new surface is judged again as many frames later. */
  static constexpr std::size_t frames_later = 2;
  /** \brief A voxel is noise without a surface near it in as many frames, the last one
   * included. */
  static constexpr std::int64_t noise_frames = 10;
  /** \brief A shown voxel is a ghost if the sensor sees through it in as many frames,
   * the last one included. */
  static constexpr std::size_t ghost_frames = 4;
  /** \brief For as many frames it may be what a moving surface left behind. */
  static constexpr std::int64_t left_frames = 20;

  /** \brief Adds the next frame.
   * \param[in] voxels of the frame, in any law
   * \param[in] truth of each voxel
   * \param[in] view of the same frame
   */
  void
  add(const io::VoxelFrame& voxels,
      const std::vector<VoxelTruth>& truth,
      TrueView view);

  /** \brief Number of frames that were added. */
  std::int64_t
  frames() const
  {
    return frames_;
  }

  /** \brief Voxels of surfaces in this frame. */
  const std::vector<std::uint64_t>&
  surfaces() const
  {
    return surfaces_;
  }

  /** \brief Voxels of the person in this frame. */
  const std::vector<std::uint64_t>&
  person() const
  {
    return person_;
  }

  /** \brief Those of surfaces that are new in this frame; none before frame
   * frames_without. */
  const std::vector<std::uint64_t>&
  newSurfaces() const
  {
    return new_.front();
  }

  /** \brief Those that were new frames_later before and have a surface near now. */
  std::vector<std::uint64_t>
  earlierNewSurfaces() const;

  bool
  isNoise(std::uint64_t key) const
  {
    return near_.lastTime(key) <= frames_ - 1 - noise_frames;
  }

  bool
  isGhost(std::uint64_t key) const;

  /** \brief Whether a surface was near in the last left_frames, and none in
   * ghost_frames: what moves has left. */
  bool
  hasBeenLeft(std::uint64_t key) const
  {
    const std::int64_t ago = frames_ - 1 - near_.lastTime(key);
    return ago >= static_cast<std::int64_t>(ghost_frames) && ago < left_frames;
  }

private:
  bool
  isNew(std::uint64_t key) const;

  io::VoxelGrid grid_;
  std::int64_t frames_ = 0;
  NearbyVoxels near_; ///< to surfaces
  std::vector<std::uint64_t> surfaces_;
  std::vector<std::uint64_t> person_;
  std::deque<std::vector<std::uint64_t>> new_; ///< this frame's first
  std::deque<TrueView> views_;                 ///< this frame's first
};

/** \brief Shown intensities against the mean of each voxel over all frames that have
 * it. */
class IntensityErrors {
public:
  /** \brief Adds the next frame.
   * \param[in] measured before the filter; contributes to the mean
   * \param[in] shown after it
   * \param[in] is_judged whether its errors count
   */
  void
  add(const io::VoxelFrame& measured, const io::VoxelFrame& shown, bool is_judged);

  /** \brief Root mean square error of the shown intensities over that of the measured
   * ones of the same voxels and frames: those that are measured and shown. Of voxels
   * that at least 80 % of the frames have; NaN without any. */
  double
  ratio() const;

private:
  /** \brief Sums over frames. */
  struct Sums {
    double count = 0.0;
    double sum = 0.0;
    double squares = 0.0;

    void
    add(double value);

    /** \brief Of the squared differences from a mean. */
    double
    squaresAround(double mean) const;
  };

  struct Voxel {
    Sums measured; ///< in all frames that have it
    Sums shown;
    Sums measured_where_shown;
  };

  std::size_t frames_ = 0;
  std::unordered_map<std::uint64_t, Voxel> voxels_;
};

/** \brief Numbers of voxels, and of those among them that are counted. */
struct CountedVoxels {
  double all = 0.0;
  double counted = 0.0;

  /** \brief NaN without voxels. */
  double
  percent() const
  {
    return 100.0 * counted / all;
  }
};

/** \brief Judges what one filter shows of a stream. */
class ShownJudge {
public:
  /** \brief Frames in which the person has fewer voxels are not judged. */
  static constexpr std::size_t least_person_voxels = 20;

  /** \brief For a stream.
   * \param[in] first_judged frame from which on surfaces, noise, ghosts and intensities
   * are judged, since the filter knows nothing at first
   */
  explicit ShownJudge(std::int64_t first_judged) : first_judged_(first_judged) {}

  /** \brief Adds the next frame.
   * \param[in] truth to which it was added last
   * \param[in] measured the frame without a filter
   * \param[in] shown the same with the filter
   */
  void
  add(const SurfaceHistory& truth,
      const io::VoxelFrame& measured,
      const io::VoxelFrame& shown);

  /** \brief Whether a voxel is within one voxel of a shown one in the frame that was
   * added last. */
  bool
  isNearShown(std::uint64_t key) const
  {
    return near_.lastTime(key) == frame_;
  }

  /** \brief How many of some voxels are. */
  CountedVoxels
  nearShown(const std::vector<std::uint64_t>& keys) const;

  // Of the surfaces' voxels, and of the person's, those near a shown one, percent of
  // each frame.
  measuring::Samples surface_percent;
  measuring::Samples person_percent;
  // The same of all frames together.
  CountedVoxels new_surface;
  CountedVoxels new_surface_later;
  // Of the shown voxels.
  CountedVoxels noise;
  CountedVoxels ghosts;
  CountedVoxels left_behind; ///< ghosts where a moving surface has left
  IntensityErrors intensity;

private:
  std::int64_t first_judged_;
  std::int64_t frame_ = -1;
  NearbyVoxels near_;
};

} // namespace noise
} // namespace pcl_ext

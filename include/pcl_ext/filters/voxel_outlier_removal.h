#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace pcl_ext {

/** \brief What the intensities of a stream tell of how densely points lie. Native ones tell
 * nothing of it, and the filter is not for them. */
enum class DensityUnit {
  /** \brief As the frames say: Faces from the first frame on that carries a depth model,
   * Points before. Frames of the published layout never carry one, so that Faces must be
   * chosen where they have the quadratic law. */
  Automatic,

  /** \brief Shares of a voxel face: the quadratic law, or the linear one in streams that
   * carry depth models. The sharpest. */
  Faces,

  /** \brief Numbers of points, of which nobody knows how many a surface makes at that
   * depth; they are compared with the voxels around. For counts, and for shares of the
   * linear law without a depth model. */
  Points
};

/** \brief All settings of a VoxelOutlierRemoval, with their units, defaults and ranges. */
struct VoxelOutlierRemovalSettings {
  /** \brief Voxels of lower log-odds are noise. Natural logarithm, finite; voxels have
   * about -12 to 12 at 4 cm.
   *
   * In the robot cell, by the sensor, at 4 cm, with the quadratic law: 0 removes 82 to 90 %
   * of the noise and about 1 % of the surfaces' voxels, 2.5 removes 95 to 96 % and 4 to 7 %,
   * fringes most of them. With counts it is 79 to 86 % and 1 to 2 %, and 7 to 13 % of the
   * surfaces at 2.5. Do not go so high where people are: of a person 87 to 97 % of the
   * voxels stay at 2.5 (counts: 86 to 92 %), but in its worst frame only 14 to 81 %; at 0 it
   * is 97 to 100 % and 66 to 96 %. See experiments/noise/README.md, for other edges, too.
   * Calibrated on a Kinect V2: with finer or coarser pixels all log-odds rise or fall
   * alike.
   */
  float min_log_odds = 0.0f;

  /** \brief What the intensities tell. */
  DensityUnit unit = DensityUnit::Automatic;

  /** \brief Intensity of a voxel face that is covered fully, above 0 and finite: 255 in
   * decoded frames of the quadratic and linear laws. Faces only, and only until a depth
   * model comes, which tells it. */
  float full_intensity = 255.0f;

  /** \brief Let the voxels of the last frames count, too. Off: those of each frame are
   * judged by themselves; a depth model stays known in any case. */
  bool use_history = true;

  /** \brief Most blocks of 4 x 4 x 4 voxels to remember between two frames, some 270 bytes
   * each; where there would be more, only those of the last frame are remembered, and if
   * that has more itself, none, and their memory is given back. Any number. While a frame
   * is judged its own blocks take as much, whatever their number: up to 400 bytes for each
   * voxel where these lie far apart. */
  std::size_t max_blocks = std::size_t{1} << 17;
};

/** \brief What came of checking the settings of a VoxelOutlierRemoval. */
enum class OutlierRemovalCode {
  Ok,             ///< all settings are within their ranges
  InvalidSettings ///< one is not
};

using OutlierRemovalStatus = Status<OutlierRemovalCode>;

/** \brief Tells whether settings are within their ranges. */
PCL_EXT_EXPORT OutlierRemovalStatus
checkSettings(const VoxelOutlierRemovalSettings& settings);

/** \brief Removes the noise from the voxels of one stream by what lies around them, now and
 * in the last frames; what StatisticalOutlierRemoval and RadiusOutlierRemoval do to
 * points, for voxels that have an intensity of the count, quadratic or linear law. It is
 * made for depth cameras, whose points lie close, and for voxels no finer than these: with
 * edges below min_resolution or above max_resolution nothing is removed. It is not made for
 * lidars: where rings are far apart most of a surface's voxels have few neighbours, and go.
 *
 * A surface is a sheet: of the voxels around one of its own some are its own, too, and
 * each is as dense as its face is covered. A flying pixel or a speckle has a ray or two.
 * So what lies around a voxel is summed up in three shells, in voxel faces:
 *
 *     f = I in the voxels of this frame, H / 2 in those of the last frames alone
 *     H_t = H_(t-1) + (I_t - H_(t-1)) / 4, with I_t = 0 where a frame has no voxel
 *     core = 2 f(voxel) + f(its 6 face neighbours)
 *     ring = f(the other 20 of the 3 x 3 x 3 voxels)
 *     rim  = f(the other 98 of the 5 x 5 x 5 voxels)
 *     log-odds = 3 ln(core + e) + (ln(ring + e) + ln(rim + e)) / 2 + c
 *
 * with e = 0.02 and c = 2.4 + 3 ln(voxel edge / 4 cm): naive Bayes, a power law for each
 * shell. The weights are those of a logistic regression on one sensor of the robot cell,
 * rounded; nothing depends on their last digit. Frames before only fill in the voxels that
 * this one leaves empty: at a surface's fringe those are some in each frame, while noise
 * that hangs there flies each time at another depth. No voxel is the denser for having
 * been there before, so that somebody who walks is judged as one who stands.
 *
 * I is a whole number of 255ths of a face, 1 to 255, or of points where the unit is
 * Points. There shells are measured in the mean of the f above 0 in the 5 x 5 x 5 voxels,
 * and c = -2.5 - 3 ln(voxel edge / 4 cm) up to 4 cm, -2.5 above. Means are held in 64ths of I, rounded up as they
 * fall, and forgotten below 1/4; H / 2 is rounded down to quarters, so that a mean below
 * 1/2 counts as nothing. All of these are integers, the same on all machines; log-odds are
 * float, and where a machine rounds them otherwise a voxel within some 1e-6 of the
 * threshold may go on one and stay on another.
 *
 * With a depth model a face counts as covered where there are sure_points_per_square_metre:
 * near the sensor, a limb that is seen at a grazing angle has few points of the hundred
 * that would cover its faces, but more than noise has. A frame without a model has that of
 * the last one: encoders leave it out where it does not pay.
 *
 * One instance serves one stream: frames of one sensor in their order, or those of
 * CentralNode::merge(). What it remembers it finds again while the grid moves on its
 * lattice, by up to two million voxels on each axis. It forgets everything, the depth
 * model too, where the grid goes farther or the resolution or the anchor changes; and the
 * means where the unit changes. A frame needs time and memory as its voxels do, wherever
 * they are; what a large one took is given back some frames later. Where memory runs out
 * std::bad_alloc is thrown, and the next frame is judged as the first one.
 *
 * With settings that checkSettings() refuses, and of frames with other edges, nothing is
 * removed, and all log-odds are plus infinity. Instances share nothing; calls of one instance from several threads must not
 * overlap. One that was moved from may only be assigned to or destroyed.
 */
class PCL_EXT_EXPORT VoxelOutlierRemoval {
public:
  /** \brief A surface of so many points is as sure as any, if there can be as many at its
   * depth; 9 on a face of 4 cm. */
  static constexpr double sure_points_per_square_metre = 5625.0;

  /** \brief Voxel edges that it is made for, metres: at 2 cm one pixel of a Kinect V2
   * covers a voxel's face 7 m away; with finer ones the voxels of far surfaces, and of far
   * people, lie apart as noise does. Coarser ones were not tried. */
  static constexpr double min_resolution = 0.02;
  static constexpr double max_resolution = 0.2;

  /** \brief Whether a voxel edge, metres, is one of those. */
  static bool
  isMadeFor(double resolution);

  explicit VoxelOutlierRemoval(
      const VoxelOutlierRemovalSettings& settings = VoxelOutlierRemovalSettings());
  ~VoxelOutlierRemoval();
  VoxelOutlierRemoval(VoxelOutlierRemoval&&) noexcept;
  VoxelOutlierRemoval&
  operator=(VoxelOutlierRemoval&&) noexcept;

  /** \brief Takes the stream's next frame and removes its noise.
   * \param[in,out] frame as isConsistent() asks; the voxels that stay keep their order
   * \return number of voxels removed
   */
  std::size_t
  filter(io::VoxelFrame& frame);

  /** \brief Takes the stream's next frame and tells of each voxel how likely it is one of
   * a surface, in place of filter().
   * \param[in] frame as isConsistent() asks
   * \param[out] log_odds natural logarithm of surface against noise, for each voxel
   */
  void
  score(const io::VoxelFrame& frame, std::vector<float>& log_odds);

  /** \brief Forgets the frames before, as at the start of a stream. */
  void
  reset();

  /** \brief Blocks of 4 x 4 x 4 voxels that are remembered. */
  std::size_t
  rememberedBlocks() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext

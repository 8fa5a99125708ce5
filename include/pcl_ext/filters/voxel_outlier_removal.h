#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace pcl_ext {

/** \brief What the intensities of a stream tell of how densely points lie. */
enum class DensityUnit {
  /** \brief As the frames say: Faces from the first frame on that carries a depth model,
   * Points before. */
  Automatic,

  /** \brief Shares of a voxel face: the quadratic law, or the linear one in frames that
   * carry a depth model. The sharpest. */
  Faces,

  /** \brief Numbers of points, of which nobody knows how many a surface makes at that
   * depth; they are compared with the voxels around. For counts, and for anything else
   * whose intensities are 1 or more where there is something. */
  Points
};

/** \brief All settings of a VoxelOutlierRemoval, with their units, defaults and ranges. */
struct VoxelOutlierRemovalSettings {
  /** \brief Voxels of lower log-odds are noise. Natural logarithm; any number. NaN and
   * minus infinity keep all voxels.
   *
   * 0: what is more likely noise than surface; in the robot cell 83 to 90 % of the noise, and
   * about 1 % of the surfaces' voxels. 2.5 removes 94 to 96 % of the noise and 3 to 6 % of
   * the surfaces' voxels, fringes most of them; see experiments/noise/README.md. Calibrated
   * on a Kinect V2: with finer or coarser pixels all log-odds rise or fall alike.
   */
  float min_log_odds = 0.0f;

  /** \brief What the intensities tell. */
  DensityUnit unit = DensityUnit::Automatic;

  /** \brief Intensity of a voxel face that is covered fully, above 0: 255 in decoded
   * frames of the quadratic and linear laws. Faces only. */
  float full_intensity = 255.0f;

  /** \brief Let the last frames count, too. Off: each frame is judged by itself. */
  bool use_history = true;

  /** \brief Most blocks of 4 x 4 x 4 voxels to remember between two frames, some 270 bytes
   * each; where there would be more, only those of the last frame are remembered, and if
   * that has more itself, none. */
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
 * points, for voxels that have an intensity.
 *
 * A surface is a sheet: of the voxels around one of its own some are its own, too, and
 * each is as dense as its face is covered. A flying pixel or a speckle has a ray or two.
 * So what lies around a voxel is summed up in three shells, in voxel faces:
 *
 *     f = I + H / 2        I: intensity in this frame, H: its running mean
 *     H_t = H_(t-1) + (I - H_(t-1)) / 4
 *     core = 2 f(voxel) + f(its 6 face neighbours)
 *     ring = f(the other 20 of the 3 x 3 x 3 voxels)
 *     rim  = f(the other 98 of the 5 x 5 x 5 voxels)
 *     log-odds = 3 ln(core + e) + (ln(ring + e) + ln(rim + e)) / 2 + c
 *
 * with e = 0.02 and c = 1.7 + 3 ln(voxel edge / 4 cm): naive Bayes, a power law for each
 * shell. The weights are those of a logistic regression on one sensor of the robot cell,
 * rounded; nothing depends on their last digit. Noise that hangs at an edge flies in some
 * frames only, each time at another depth, which the running mean tells from a surface; as
 * this frame counts more than all before, an object that has just come is judged by its own
 * density.
 * With a depth model, a surface of 5625 points a square metre (9 on a face of 4 cm) is as
 * sure as any: near the sensor, a limb that is seen at a grazing angle has few points of the
 * hundred that would cover its faces, but more than noise has.
 * Where the unit is Points, shells are measured in the mean f of the occupied voxels of the
 * 5 x 5 x 5, and c = -2.5 - 3 ln(voxel edge / 4 cm).
 *
 * One instance serves one stream: frames of one sensor in their order, or those of
 * CentralNode::merge(). What it remembers it finds again while the grid moves on its
 * lattice; it forgets everything where the resolution, the anchor or the unit changes.
 * A frame needs time and memory as its voxels do, wherever they are.
 */
class PCL_EXT_EXPORT VoxelOutlierRemoval {
public:
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

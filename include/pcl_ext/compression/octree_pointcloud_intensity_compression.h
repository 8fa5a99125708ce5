// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/impl/cloud_streams.h>
#include <pcl_ext/compression/impl/pcl_conventions.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/impl/library_instances.h>
#include <pcl_ext/impl/point_intensity.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/octree/octree_pointcloud_intensity.h>
#include <pcl_ext/status.h>

#include <pcl/compression/compression_profiles.h>
#include <pcl/memory.h>

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <type_traits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief The default intensity model of a point type: native if the type has an
 * intensity, else none. */
template <typename PointT>
using DefaultIntensityModel =
    std::conditional_t<has_intensity_field<PointT>, NativeIntensity, NoIntensity>;

namespace detail {

/** \brief True for types that fulfil the contract of IntensityModel. */
template <typename ModelT, typename = void>
struct IsIntensityModel : std::false_type {};

template <typename ModelT>
struct IsIntensityModel<ModelT,
                        std::void_t<decltype(ModelT::unit),
                                    decltype(ModelT::uses_depth),
                                    decltype(ModelT::uses_native)>>
: std::is_invocable_r<float, const ModelT&, float, float> {};

/** \brief The model for a voxel edge in metres. */
template <typename ModelT>
ModelT
modelOf(double resolution)
{
  static_assert(std::is_constructible<ModelT, double>::value,
                "the intensity model has no constructor from the voxel edge in metres: "
                "pass an instance after the settings, or, if it is a law, name "
                "pcl_ext::IntensityModel<Sensor, Law>");
  return ModelT(resolution);
}

} // namespace detail

/** \brief Compresses streams of point clouds into voxels with an intensity; replaces
 * pcl::io::OctreePointCloudCompression.
 *
 * Encoding assigns the points to the voxels of a grid and keeps an intensity and the
 * mean colour of each voxel, if the point type has such fields; decoding returns one
 * point at the centre of each occupied voxel. With settings.keep_points it
 * returns all points: of clouds that have the order of a sensor in this order, each at
 * a place of its own; of others at the centres of their voxels. A point moves by at
 * most half a voxel's diagonal; settings.fields names what else of it is coded.
 *
 * Intended differences to PCL's class: both calls return a status; an empty cloud is an
 * ordinary frame; the grid is anchored at the world origin unless clouds lie far from
 * it; iFrameRate = N means every N-th frame (PCL: every N+1-th); decoding never hangs,
 * throws or allocates without bound.
 *
 * The library has the class for pcl::PointXYZ, PointXYZI, PointXYZRGB and PointXYZRGBA
 * with the default model. Other classes are instantiated in the program, with its flags;
 * so are these where a flag, as -mavx, changes how memory of clouds is allocated and
 * freed (pcl_ext/impl/library_instances.h). Programs with a point type of their own
 * include pcl_ext/octree/impl/octree_pointcloud_intensity.hpp, see
 * octree::OctreePointCloudIntensity.
 *
 * An instance serves one stream in each direction; its encoder and its decoder are
 * independent of each other. Instances share nothing; one instance is for one thread.
 * \tparam PointT point type with x, y, z
 * \tparam IntensityModelT intensity of one point, see IntensityModel for the contract
 * \tparam LeafT leaf of the octree that settings.retain_octree keeps
 * \tparam BranchT branch of that octree
 * \tparam OctreeT its base, pcl::octree::Octree2BufBase or pcl::octree::OctreeBase
 */
template <typename PointT,
          typename IntensityModelT = DefaultIntensityModel<PointT>,
          typename LeafT = octree::IntensityLeaf,
          typename BranchT = pcl::octree::OctreeContainerEmpty,
          typename OctreeT = pcl::octree::Octree2BufBase<LeafT, BranchT>>
class OctreePointCloudIntensityCompression
: public octree::OctreePointCloudIntensity<PointT, LeafT, BranchT, OctreeT> {
public:
  using Base = octree::OctreePointCloudIntensity<PointT, LeafT, BranchT, OctreeT>;
  using PointCloud = typename Base::PointCloud;
  using PointCloudPtr = typename Base::PointCloudPtr;
  using PointCloudConstPtr = typename Base::PointCloudConstPtr;

  using Ptr = pcl::shared_ptr<OctreePointCloudIntensityCompression>;
  using ConstPtr = pcl::shared_ptr<const OctreePointCloudIntensityCompression>;

  using LeafNode = typename OctreeT::LeafNode;
  using BranchNode = typename OctreeT::BranchNode;

  using RealTimeStreamCompression =
      OctreePointCloudIntensityCompression<PointT,
                                           IntensityModelT,
                                           LeafT,
                                           BranchT,
                                           pcl::octree::Octree2BufBase<LeafT, BranchT>>;
  using SinglePointCloudCompressionLowMemory =
      OctreePointCloudIntensityCompression<PointT,
                                           IntensityModelT,
                                           LeafT,
                                           BranchT,
                                           pcl::octree::OctreeBase<LeafT, BranchT>>;

  /** \brief PCL's constructor: its arguments, order and defaults, and what they mean.
   *
   * Where PCL keeps every point, voxels have the edge to which PCL keeps the points,
   * below a millimetre 1.25 times that, and as many points as were in them. A profile
   * also sets the effort: streams take fewer bytes than PCL's and no more time on the
   * clouds of doc/benchmarks.md, which also tells where a single frame can take more.
   * The arguments after show_statistics are used by MANUAL_CONFIGURATION only. Where
   * octree_resolution is finer than point_resolution it is the voxel edge; where it is
   * that as a float (0.25, not 0.01) voxels have one point, as PCL's. Clouds wider than
   * 2^21 voxels get coarser ones (coarsen_wide_clouds), and clouds whose coordinates are
   * multiples of a larger step get voxels of that edge (use_coordinate_step).
   * \param[in] profile compression profile
   * \param[in] show_statistics print the statistics of each frame on PCL's console
   * \param[in] point_resolution voxel edge, metres, without down-sampling; see above
   * \param[in] octree_resolution voxel edge, metres, with down-sampling
   * \param[in] do_voxel_grid_down_sampling decode one point for each voxel
   * \param[in] i_frame_rate frames from one I-frame to the next
   * \param[in] do_color_encoding code the colour of point types that have one
   * \param[in] color_bit_resolution bits of a colour channel, 1..8
   */
  OctreePointCloudIntensityCompression(
      pcl::io::compression_Profiles_e profile =
          pcl::io::MED_RES_ONLINE_COMPRESSION_WITH_COLOR,
      bool show_statistics = false,
      double point_resolution = 0.001,
      double octree_resolution = 0.01,
      bool do_voxel_grid_down_sampling = false,
      unsigned int i_frame_rate = 30,
      bool do_color_encoding = true,
      unsigned char color_bit_resolution = 6)
  : OctreePointCloudIntensityCompression(
        detail::settingsOfArguments(profile,
                                    show_statistics,
                                    {i_frame_rate,
                                     octree_resolution,
                                     point_resolution,
                                     do_voxel_grid_down_sampling,
                                     do_color_encoding,
                                     color_bit_resolution}))
  {}

  /** \brief All settings by name, and a model constructed from the resolution.
   * \param[in] settings checked here; if a value is out of range, every call to
   * encodePointCloud returns InvalidSettings, and to decodePointCloud if it is a limit
   */
  explicit OctreePointCloudIntensityCompression(
      const IntensityCompressionSettings& settings)
  : OctreePointCloudIntensityCompression(
        settings, detail::modelOf<IntensityModelT>(detail::octreeResolution(settings)))
  {}

  /** \brief All settings by name, and a model with parameters of its own.
   * \param[in] settings as above
   * \param[in] intensity_model intensity of one point
   */
  OctreePointCloudIntensityCompression(const IntensityCompressionSettings& settings,
                                       const IntensityModelT& intensity_model);

  ~OctreePointCloudIntensityCompression() override;

  /** \brief Takes over both streams. A retained octree is built again from its frame.
   * The source may then only be destroyed or assigned to. */
  OctreePointCloudIntensityCompression(OctreePointCloudIntensityCompression&& source);

  /** \brief The same; source must be another instance. */
  OctreePointCloudIntensityCompression&
  operator=(OctreePointCloudIntensityCompression&& source);

  /** \brief Sets the cloud that getOutputCloud returns; so does decodePointCloud. */
  void
  setOutputCloud(const PointCloudPtr& cloud)
  {
    output_ = cloud;
  }

  /** \brief The cloud that was decoded last. */
  PointCloudPtr
  getOutputCloud() const
  {
    return output_;
  }

  /** \brief Encodes the next cloud of the stream.
   *
   * Points that are not finite, outside settings.bounding_box or more than 2^20 voxels
   * from the origin are counted and left out.
   * \param[in] cloud in the coordinates of the grid, metres; may be empty
   * \param[in,out] compressed_cloud takes the frame's bytes
   * \return Ok; InvalidSettings; InvalidInput for a null cloud, or if the intensity
   * model uses the depth and the cloud's pose is not finite; OutputFailed or
   * OutOfMemory, after which the next frame is an I-frame. Ok has a message with
   * numbers (Status::hasWarning) if not all finite points are in the frame as they are,
   * see CloudEncoder::encode; the first of each kind is also printed on PCL's console
   */
  CompressionStatus
  encodePointCloud(const PointCloudConstPtr& cloud, std::ostream& compressed_cloud);

  /** \brief The same into memory.
   * \param[in] cloud as above
   * \param[out] compressed_cloud the frame's bytes; empty unless the status is Ok
   */
  CompressionStatus
  encodePointCloud(const PointCloudConstPtr& cloud,
                   std::vector<std::uint8_t>& compressed_cloud);

  /** \brief Encodes the voxels of an octree as the next frame of the stream: as a cloud
   * with a point at the centre of each leaf, with the leaf's intensity and colour.
   *
   * Whatever the leaves have accumulated is coded, in the unit of the intensity model;
   * the model itself is not asked. Where the octree's voxels do not begin at multiples of
   * their edge, all are moved to the nearest that do.
   * \param[in] tree an OctreePointCloudIntensity, or a PCL octree whose leaves have
   * getIntensity(), and getColour() for colours; of the resolution of the settings. It is
   * not const, as PCL's iterators need
   * \param[out] compressed_cloud the frame's bytes; empty unless the status is Ok
   * \return as encodePointCloud; InvalidInput for an octree of another resolution
   */
  template <typename TreeT>
  CompressionStatus
  encodeOctree(TreeT& tree, std::vector<std::uint8_t>& compressed_cloud);

  /** \brief The same, written to a stream. */
  template <typename TreeT>
  CompressionStatus
  encodeOctree(TreeT& tree, std::ostream& compressed_cloud);

  /** \brief Decodes the next frame of a stream, of either format.
   *
   * The stream must contain the complete frame. Never throws, hangs or exceeds
   * settings.decoder_limits. Bytes before the frame are skipped. If no frame is decoded,
   * the cloud is empty and the history unchanged, so that decoding recovers at the
   * latest with the next I-frame that did not come before (OldFrame). A stream of which
   * a part has arrived stays where that begins with settings.incomplete_frame = Keep.
   * \param[in,out] compressed_cloud where to read; then positioned after the frame.
   * At its end the stream gets its end and fail bits, as from a read
   * \param[in,out] cloud takes the voxel centres in Morton order, metres, or the points
   * in the order of their sensor where the frame has it (VoxelFrame::points): in rows and
   * columns, if it has these; a null pointer gets a cloud
   */
  CompressionStatus
  decodePointCloud(std::istream& compressed_cloud, PointCloudPtr& cloud);

  /** \brief Decodes the first frame in memory. It ends at statistics().coding:
   * skipped_bytes + bytes. See frameSize() for bytes that arrive in pieces.
   * \param[in] bytes the first byte
   * \param[in] size number of bytes
   * \param[in,out] cloud as above
   */
  CompressionStatus
  decodePointCloud(const std::uint8_t* bytes, std::size_t size, PointCloudPtr& cloud);

  /** \brief Changes the resolution of the following encoded frames; the next one is an
   * I-frame. A retained octree is deleted.
   * \param[in] resolution voxel edge, metres; checked as that of the settings
   */
  void
  setResolution(double resolution);

  /** \brief Does nothing: the profile is applied by the constructor. */
  void
  initialization()
  {}

  /** \brief Makes the next encoded frame an I-frame, for a receiver that lost a
   * frame. */
  void
  requestIFrame()
  {
    streams_.requestIFrame();
  }

  /** \brief Changes settings().max_rate as the link does, bits a second above 0; only
   * where there is one. */
  void
  setMaxRate(double bits_per_second)
  {
    streams_.setMaxRate(bits_per_second);
  }

  /** \brief What the rate control chose for the last cloud, and why. The time of a cloud
   * is its stamp, or without one that of the call. */
  RateControlStatus
  rateControlStatus() const
  {
    return streams_.rateControlStatus();
  }

  /** \brief Statistics of the frame that was encoded or decoded last. */
  const FrameStatistics&
  statistics() const
  {
    return streams_.statistics();
  }

  /** \brief The settings in force, those of a profile included. */
  const IntensityCompressionSettings&
  settings() const
  {
    return streams_.settings();
  }

  /** \brief The model that computes the intensity of a point. */
  const IntensityModelT&
  intensityModel() const
  {
    return intensity_model_;
  }

  /** \brief The voxels that were encoded or decoded last. After decodePointCloud voxel
   * i is point i of the cloud, unless the frame has numbers of points: then each voxel
   * has that many points, and VoxelFrame::cloudIndex() tells where they are. Voxels of a
   * frame that has its points are made by the first call: not at the same time as any
   * other call, and it throws std::bad_alloc if memory runs out. */
  const VoxelFrame&
  voxelFrame() const
  {
    return streams_.voxelFrame();
  }

private:
  static_assert(
      detail::IsIntensityModel<IntensityModelT>::value,
      "the second template argument must be an intensity model; leaf, branch and "
      "octree, which follow the point type in PCL's class, come after it: "
      "OctreePointCloudIntensityCompression<PointT, "
      "pcl_ext::io::DefaultIntensityModel<PointT>, LeafT, BranchT, OctreeT>, with a "
      "leaf as pcl_ext::octree::IntensityLeaf; most programs need none of them. A "
      "model of your own has unit, uses_depth, "
      "uses_native and float operator()(float depth, float native) const");
  static_assert(
      !std::is_same<IntensityModelT, NativeIntensity>::value ||
          has_intensity_field<PointT>,
      "NativeIntensity is the point's own intensity, but the point type has no "
      "field intensity: use pcl::PointXYZI, or name another intensity model");

  template <typename EncodeT>
  CompressionStatus
  encodeTo(std::ostream* output, std::vector<std::uint8_t>& bytes, EncodeT encode);

  CompressionStatus
  encodeFrame(const PointCloudConstPtr& cloud, std::vector<std::uint8_t>& bytes);

  template <typename TreeT>
  CompressionStatus
  encodeLeaves(TreeT& tree, std::vector<std::uint8_t>& bytes);

  template <typename DecodeT>
  CompressionStatus
  decodeSafely(PointCloudPtr& cloud, DecodeT decode);

  void
  finishFrame(const char* title)
  {
    if (settings().retain_octree)
      retainOctree();
    streams_.showStatistics(title);
  }

  void
  retainOctree();

  void
  takeOctree(OctreePointCloudIntensityCompression& source);

  IntensityModelT intensity_model_;
  detail::CloudStreams streams_;
  PointCloudPtr output_;
  std::vector<float> intensities_; // a member so that its memory is reused
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io

#include <pcl_ext/compression/impl/octree_pointcloud_intensity_compression.hpp>

#if PCL_EXT_USES_INSTANCES
namespace pcl_ext::PCL_EXT_ABI::io {

extern template class PCL_EXT_EXPORT
    OctreePointCloudIntensityCompression<pcl::PointXYZ>;
extern template class PCL_EXT_EXPORT
    OctreePointCloudIntensityCompression<pcl::PointXYZI>;
extern template class PCL_EXT_EXPORT
    OctreePointCloudIntensityCompression<pcl::PointXYZRGB>;
extern template class PCL_EXT_EXPORT
    OctreePointCloudIntensityCompression<pcl::PointXYZRGBA>;

} // namespace pcl_ext::PCL_EXT_ABI::io
#endif

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/decoder_limits.h>
#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/export.h>
#include <pcl_ext/impl/named_value.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief Trade-off of time against size, for encoder and decoder alike. For figures
 * see doc/benchmarks.md. For single or unrelated frames the order of the sizes may
 * differ. */
enum class Effort {
  Fast,     ///< live streams; a quarter of Balanced's time
  Balanced, ///< recordings; 8 % fewer bytes than Fast at 4 cm
  Small     ///< archives, thin links; fewer bytes for twice the time
};

inline constexpr std::array<NamedValue<Effort>, 3> efforts = {
    {{Effort::Fast, "fast"}, {Effort::Balanced, "balanced"}, {Effort::Small, "small"}}};

/** \brief The bitstream to write. Decoders detect it by its first bytes. */
enum class StreamFormat {
  Version1, ///< this library's own, see doc/bitstream.md
  Published ///< as the paper's authors published it, to replace one end at a time
};

inline constexpr std::array<NamedValue<StreamFormat>, 2> stream_formats = {
    {{StreamFormat::Version1, "version1"}, {StreamFormat::Published, "published"}}};

/** \brief How the intensities of the points are combined in a voxel. */
enum class Aggregation {
  Automatic, ///< Mean for native intensities in Version1, else Sum
  Sum,       ///< I_v = sum of I_p (section 2.5.4 of the paper)
  Mean       ///< the mean, for native intensities
};

inline constexpr std::array<NamedValue<Aggregation>, 3> aggregations = {
    {{Aggregation::Automatic, "automatic"},
     {Aggregation::Sum, "sum"},
     {Aggregation::Mean, "mean"}}};

/** \brief How intensities are mapped to symbols. */
enum class IntensityCurve {
  Linear,   ///< steps of the same size
  Companded ///< small numbers exact, then steps that grow, see compandedEdge
};

inline constexpr std::array<NamedValue<IntensityCurve>, 2> intensity_curves = {
    {{IntensityCurve::Linear, "linear"}, {IntensityCurve::Companded, "companded"}}};

/** \brief What a decoder does with a frame of which only the beginning has arrived. */
enum class IncompleteFrame {
  Skip, ///< the next call searches for another frame after its first byte
  Keep  ///< a stream that can seek stays at its first byte, for a call with more bytes
};

/** \brief The voxels that clouds are divided into. */
struct GridSettings {
  /** \brief Voxel edge d_v, metres. 1e-6 to 1e6. */
  double resolution = 0.01;

  /** \brief World position, metres, from which voxels are counted, 2^20 each way. None:
   * automatic, which is the world's origin, or for clouds further out a corner of its
   * voxels amid the points. Where all coordinates of a cloud are multiples of the
   * resolution, as whole millimetres are of 1 mm, it is half a voxel lower, so that they
   * are the centres of voxels and are kept as they are; not for shares of a voxel face.
   * Version1 only. */
  std::optional<std::array<double, 3>> origin;

  /** \brief Fixed box, world coordinates, metres; points outside are counted and left
   * out. None: the grid follows the points. min < max on each axis. */
  std::optional<BoundingBox> bounding_box;

  /** \brief For clouds wider than 2^21 voxels double the resolution as often as needed,
   * up to 16-fold, instead of leaving points out; the status warns of it. If that is
   * not enough, up to a sixteenth of the points is left out; with more far ones the
   * resolution is 16-fold where that keeps more than twice as many points, or else it
   * stays. Not for shares of a voxel face, whose unit is the voxel. */
  bool coarsen_wide_clouds = false;

  /** \brief Where all coordinates of a cloud are, to a quarter of the resolution,
   * multiples of a larger step, as of sensors whose coordinates are whole millimetres,
   * take voxels of that edge, centred on the multiples: fewer bytes, and coordinates as
   * they were. Steps are 1, 2 or 5 times a power of ten up to 0.1 m, and at least twice
   * the resolution. Not for shares of a voxel face, nor with an origin or a bounding
   * box. Version1 only. Points in order are always coded so, see keep_points. */
  bool use_coordinate_step = false;
};

/** \brief The intensities of voxels and their scale. */
struct IntensitySettings {
  /** \brief Sum or mean of the point intensities in a voxel. */
  Aggregation aggregation = Aggregation::Automatic;

  /** \brief Intensity at the top of the scale, in the unit of the intensity model
   * (points, share of a voxel face, or the sensor's own); above it a voxel saturates.
   *
   * 0: automatic, which is a share of 1, or a range that follows counts and native
   * intensities; counts on a linear scale of intensity_bits have 0 to
   * 2^intensity_bits - 1. The range holds all values but few that are far from the
   * others, as those of lost returns: at most one voxel in 256 at each end. These are
   * set to the end of the scale, and the status warns of their number; see
   * doc/bitstream.md. With a range all negative intensities are held. Finite, not
   * negative. Published: 0 or 255, where its scale ends.
   */
  float intensity_range = 0.0f;

  /** \brief Bits of an intensity symbol, 1..16, or 0: automatic.
   *
   * Automatic is 8 for shares, and for counts with a range. Else counts and native
   * whole numbers get the 8 to 16 bits that make a step of 1, multiples of 0.01, 1/255
   * and similar fractions those that make that step, which more bits keep, others 16.
   * On a companded scale automatic is 4. Published: 0 or 8.
   */
  unsigned int intensity_bits = 0;

  /** \brief Linear or companded. The noise of a count grows with its square root, so
   * that 3 or 4 companded bits suffice, and thresholds of 2 to 5 points have the same
   * result as without loss.
   *
   * Companding applies to whole numbers of a step and keeps small ones exact: counts
   * from 1 to 255 or as far as needed, or to intensity_range; shares in steps of 1/255
   * of the range; native whole numbers in steps of 1, others in 2^8 to 2^16 steps. See
   * doc/bitstream.md. If the bits suffice for all numbers, the scale is linear. Version1
   * only.
   */
  IntensityCurve intensity_curve = IntensityCurve::Linear;
};

/** \brief A field of the points that is kept. */
struct FieldSetting {
  std::string name;  ///< of the field, or `all_fields`
  double step = 0.0; ///< see FieldDescription; of integers a whole number
};

/** \brief In the place of a name, without a step: all fields that can be kept and that no
 * other setting names, but x, y, z. With colour_bits, rgb and rgba are among them in
 * frames of voxels whose points are kept, as the colours of these are means; a scan has
 * the colours of its points in 8 bits a channel instead. It means all also where a field
 * is called so. */
inline constexpr char all_fields[] = "all";

/** \brief The stream and what its frames have besides intensities. */
struct StreamSettings {
  /** \brief Bitstream to write. */
  StreamFormat format = StreamFormat::Version1;

  /** \brief Time against size; Version1 only. A decoder reads all three. What writes
   * files may rather take Balanced. */
  Effort effort = Effort::Fast;

  /** \brief Most frames from one I-frame to the next; 0 and 1 make every frame an
   * I-frame. */
  unsigned int i_frame_rate = 30;

  /** \brief Seconds after which an I-frame comes by the times of the clouds, 0.001 to
   * 86400, so that a seek soon shows something; 0: by i_frame_rate alone. An I-frame is
   * the first cloud whose time is at least so long after that of the last I-frame, or
   * before it, as where a recording begins again; i_frame_rate may have one earlier.
   * Clouds without a time are counted only. */
  double i_frame_every = 0.0;

  /** \brief Number of the first frame; above 1 for an encoder that goes on with a stream
   * from an I-frame on, as where parts of a recording are encoded side by side. Version1
   * only. */
  std::uint32_t first_frame_number = 1;

  /** \brief Bits of a colour channel, 1..8, or 0: colour is not coded. A voxel has the
   * mean colour of its points. Where clouds have no colour it has no effect. Published:
   * not coded, about which the status of each coloured cloud warns unless this is 0. */
  unsigned int colour_bits = 6;

  /** \brief Keep all points, so that a decoded cloud has as many finite ones as the encoded one.
   *
   * A cloud is coded as a scan where that takes hardly more bytes than voxels do, at most
   * 5 % and 256. Its points come back in the order of the cloud, those of a lidar whose
   * points do not come as its lasers fire row by row; each coordinate within half an
   * edge, with intensities and colours of their own. For intensities of sums, and where
   * noise is removed, there are voxels only.
   *
   * Otherwise the number of points of each voxel is coded: each of them comes back at
   * its voxel's centre, and with its voxel's intensity, which for sums is that of all
   * of them. Version1 only. */
  bool keep_points = false;

  /** \brief Keep the order of the points, and the rows and columns of an organised cloud,
   * whatever bytes that takes. A cloud whose order cannot be kept is not coded: one with
   * more than 2^24 pixels or points, or with points 6.6e7 edges apart. All points are kept
   * then. Points that are not finite have a place in rows and columns only: a cloud of one
   * row or of one column comes back as one row of its finite points. Not for intensities
   * of sums, nor where noise is removed from voxels. */
  bool keep_order = false;

  /** \brief Whether all points are kept. */
  bool
  keepsPoints() const
  {
    return keep_points || keep_order;
  }

  /** \brief Further fields to keep, as ring, time or label of a lidar: with keep_points of
   * each point, else one value of a voxel, which is the mean, of packed colours that of
   * each channel, or of integers the most frequent. Exact, or rounded to a step. The
   * points of a voxel are in the order of the first field, those of a scan in that of the
   * cloud. At most 64 with 4096 values a point, each named once. Version1 only, and not
   * with temporal_filter. */
  std::vector<FieldSetting> fields;
};

/** \brief A budget for the stream, which RateControl keeps. */
struct RateSettings {
  /** \brief Bits a second that the frames of any second may take, 1e3 to 1e12, or 0: no
   * limit. Clouds that find no room are left out; other settings become coarser so that
   * these are few. Bytes that a transport adds are not counted. */
  double max_rate = 0.0;

  /** \brief Seconds at max_rate that a frame may take, and wait for the ones before it to
   * be sent: the size of the sender's buffer. 0.01 to 1. */
  double rate_buffer = 0.25;

  /** \brief Milliseconds that the last frames may take on average, from points to bytes,
   * 0.1 to 1e4, or 0: no limit. Effort and then the voxels follow; with max_rate the
   * effort also rises above `effort` before anything is lost. */
  double max_encode_ms = 0.0;

  /** \brief Strongest temporal_filter that max_rate may choose, frames, 2 to 64, or 0:
   * none. Unless temporal_filter is set, too, it shows nothing that the cloud has nothing
   * within one voxel of, and it is not used where the sensor moves, nor with
   * keep_points or fields. */
  unsigned int rate_temporal_filter = 8;

  /** \brief How often the voxel edge may be doubled, 0 to 8. */
  unsigned int rate_doublings = 4;

  /** \brief Share of the clouds that max_rate keeps with voxels of an edge, by leaving
   * others out, before it doubles the edge, 0.1 to 1. A third of the clouds shows more
   * of a scene than all with voxels of twice the edge, see doc/rate_control.md; 1 is
   * for those that need each cloud. */
  double rate_sent_share = 0.33;
};

/** \brief Range of RateSettings::max_rate, bits a second. */
inline constexpr double least_max_rate = 1e3;
inline constexpr double most_max_rate = 1e12;

/** \brief All that CloudEncoder can be set to, and the budget that RateControl keeps with
 * it.
 *
 * The published layout refuses settings that change what is decoded and that it has no
 * field for; effort and depth law, which change bytes and time only, have no effect
 * there.
 */
struct EncoderSettings : GridSettings, IntensitySettings, StreamSettings, RateSettings {
  /** \brief Most threads that encode a cloud, 1 to 256: as voxels these are found by all
   * of them; as a scan places are, and fields are coded beside the rest. Smaller clouds
   * than 32768 points a thread use fewer. The bytes do not depend on it. */
  unsigned int threads = 1;

  /** \brief Limits of the stream's decoders: a frame beyond them has a warning. */
  DecoderLimits decoder_limits;

  /** \brief Number of frames over which surfaces are told from noise before they are
   * encoded, 2 to 64, or 0: off. 8 suits sensors of 10 to 30 frames a second that stand
   * still: an eighth to a fifth of the bytes. Lossy, see TemporalVoxelFilter, and not
   * with keep_points. */
  unsigned int temporal_filter = 0;

  /** \brief Whether the temporal_filter shows a voxel for up to a quarter of a second (at
   * strength 8) though the cloud has nothing within one voxel of it. RateControl does
   * without, where it turns the filter on by itself. */
  bool temporal_filter_holds = true;
};

/** \brief All settings of OctreePointCloudIntensityCompression, with their units,
 * defaults and ranges: those of its encoder, whose decoder_limits are those of its
 * decoder, too, and more. */
struct IntensityCompressionSettings : EncoderSettings {
  /** \brief Pose of the sensor in the coordinate frame of the clouds that are encoded
   * (sensor -> cloud), for the depth of the points, their rays (PointView::image) and
   * temporal_filter. None: the cloud's own sensor_origin_ and sensor_orientation_. */
  std::optional<SensorPose> sensor_pose;

  /** \brief The law of the clouds' own intensities, as computed by SensorPreprocessor.
   * With it and the sensor's pose (above) frames take fewer bytes, see
   * doc/benchmarks.md. A hint: a wrong law costs bytes, but no accuracy; it is ignored
   * where it saves nothing. None: that of the class's intensity model, if it depends on
   * the depth. Exponent 1 or 2; depth and intensity above 0. Linear scales of Version1
   * only. */
  std::optional<DepthLaw> depth_law;

  /** \brief Code header.stamp and header.frame_id. Version1 only. */
  bool carry_header = false;

  /** \brief What decoding does with a frame of which only the beginning is in the
   * stream. */
  IncompleteFrame incomplete_frame = IncompleteFrame::Skip;

  /** \brief Keep the last encoded or decoded frame as an octree for the inherited
   * octree queries. A leaf has one point, its voxel, with the voxel's intensity, or 1
   * without. */
  bool retain_octree = false;

  /** \brief Print the statistics of each frame on PCL's console. */
  bool show_statistics = false;
};

/** \brief Reads names of fields with commas between them, each with :STEP if it has one,
 * as "ring,time:1e-6" or "all". A name that has a colon needs a step; one with a comma
 * cannot be given.
 * \param[out] fields none for an empty text
 * \return Ok, or InvalidSettings with the text
 */
PCL_EXT_CODEC_EXPORT CompressionStatus
parseFields(const std::string& text, std::vector<FieldSetting>& fields);

/** \brief Whether `all_fields` stands for a field, too.
 * \param[in] field of a cloud, not x, y or z
 * \param[in] codes_colours the frame has colours besides that are those of its fields'
 * values: colour_bits is not 0, and it is not one of voxels whose points are kept
 */
PCL_EXT_CODEC_EXPORT bool
isOneOfAllFields(const FieldDescription& field, bool codes_colours);

/** \brief Checks the settings of an encoder against their ranges and each other.
 * \param[in] depth_law see IntensityCompressionSettings
 * \return Ok, or InvalidSettings with the field and its value
 */
PCL_EXT_CODEC_EXPORT CompressionStatus
checkSettings(const EncoderSettings& settings,
              const std::optional<DepthLaw>& depth_law = std::nullopt);

/** \brief Checks all settings. */
PCL_EXT_CODEC_EXPORT CompressionStatus
checkSettings(const IntensityCompressionSettings& settings);

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io

#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "codec/coding_workspace.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief The most voxels that a frame may have, whatever the limits: places of voxels in
 * the history have 32 bits. */
constexpr std::size_t largest_frame = std::size_t{1} << 24;

/** \brief Records that a stream's history may hold when a P-frame comes, where no frame
 * has more than some number of voxels: encoders start again at an I-frame, decoders
 * refuse. */
constexpr std::size_t
maxRecords(std::size_t voxels)
{
  // Streams of fixed sensors have two to five for each voxel.
  const std::size_t of_small_frames = 8 * voxels + (std::size_t{1} << 16);
  const std::size_t of_large_frames = 2 * voxels + (std::size_t{1} << 20);
  return of_small_frames < of_large_frames ? of_small_frames : of_large_frames;
}

/** \brief Bytes of a payload by what they tell. A coder that mixes both in one row of
 * symbols calls all of them occupancy but for what it can tell apart. */
struct PayloadSizes {
  std::size_t occupancy = 0;
  std::size_t intensity = 0;
};

/** \brief Turns the voxels of one stream's frames into payloads and back; keeps the
 * stream's history. One instance serves one direction. */
class PayloadCoder {
public:
  virtual ~PayloadCoder() = default;

  /** \brief Appends the payload of the next frame of the stream, and learns it. An
   * exception leaves the coder fit for nothing but its end.
   * \param[in,out] work memory for it
   * \param[in] frame consistent; it may be without voxels
   * \param[in] is_i_frame forget what was before
   * \param[in,out] payload where to append
   */
  virtual PayloadSizes
  encode(CodingWorkspace& work,
         const VoxelFrame& frame,
         bool is_i_frame,
         std::vector<std::uint8_t>& payload) = 0;

  /** \brief Reads back what encode appended; either learn() or discard() follows if that
   * succeeds. A failure leaves what was learnt as it was; an exception leaves the coder fit
   * for nothing but its end.
   * \param[in,out] work memory for it, not to be used for other frames before
   * \param[in] begin first byte
   * \param[in] end end of the payload, all of which must be used
   * \param[in] voxel_count number of voxels of the frame
   * \param[in] is_i_frame as for encode
   * \param[in,out] frame its voxels are filled; the rest is given
   * \param[out] sizes as encode returns
   * \return false if the bytes are no payload of that many voxels
   */
  virtual bool
  decode(CodingWorkspace& work,
         const std::uint8_t* begin,
         const std::uint8_t* end,
         std::size_t voxel_count,
         bool is_i_frame,
         VoxelFrame& frame,
         PayloadSizes& sizes) = 0;

  /** \brief Learns the frame that was decoded last. */
  virtual void
  learn() noexcept = 0;

  /** \brief Leaves what was learnt as it was before the frame that was decoded last. */
  virtual void
  discard() noexcept = 0;

  /** \brief Gives back the memory that what was learnt does not need. */
  virtual void
  giveBackMemory() = 0;

  /** \brief How much of a frame the history knows.
   * \param[in,out] work memory for it
   * \param[in] frame the voxels
   * \return number of its voxels that have a record
   */
  virtual std::size_t
  knownVoxels(CodingWorkspace& work, const VoxelFrame& frame) = 0;

  /** \brief Number of voxels that have a record. */
  virtual std::size_t
  recordCount() const = 0;
};

/** \brief The coders of one stream by effort, each made when it is first asked for. */
class PayloadCoders {
public:
  PayloadCoder&
  of(Effort effort);

  /** \brief Records of the coder of an effort, if there is one. */
  std::size_t
  recordCount(Effort effort) const;

  /** \brief Ends all coders but that of an effort. */
  void
  keepOnly(Effort effort) noexcept;

  /** \brief Ends all coders: nothing is known any more. */
  void
  clear() noexcept;

private:
  std::array<std::unique_ptr<PayloadCoder>, 3> coders_;
};

} // namespace io
} // namespace pcl_ext

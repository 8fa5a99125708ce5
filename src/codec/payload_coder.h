#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "voxels/memory_rule.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace io {

namespace fast {
struct Workspace;
} // namespace fast

/** \brief The most voxels that a frame may have, whatever the limits: a voxel's place in
 * the history has 32 bits. */
constexpr std::size_t largest_frame = std::size_t{1} << 24;

/** \brief The most records that a stream's history may have when a P-frame comes: an
 * encoder makes an I-frame instead, a decoder refuses the frame.
 * \param[in] voxels of the frame for an encoder, the limit for a decoder
 */
constexpr std::size_t
maxRecords(std::size_t voxels)
{
  // Streams of fixed sensors have two to five for each voxel.
  const std::size_t of_small_frames = 8 * voxels + (std::size_t{1} << 16);
  const std::size_t of_large_frames = 2 * voxels + (std::size_t{1} << 20);
  return of_small_frames < of_large_frames ? of_small_frames : of_large_frames;
}

/** \brief Bytes of a payload by what they code. What a coder cannot tell apart counts as
 * occupancy. */
struct PayloadSizes {
  std::size_t occupancy = 0;
  std::size_t intensity = 0;
};

/** \brief Memory for a frame while it is coded; streams may take turns with one. See
 * CodingMemory. */
class CodingWorkspace {
public:
  CodingWorkspace();
  ~CodingWorkspace();

  /** \brief That of effort fast, made at the first call; the other efforts have none. */
  fast::Workspace&
  fast();

  /** \brief Ends a frame. Gives memory back that frames of long ago needed, and the last
   * ones did not.
   * \param[in] needed by the frame, in voxels and bytes
   * \param[in] taken for it, likewise
   */
  void
  endFrame(std::size_t needed, std::size_t taken);

private:
  std::unique_ptr<fast::Workspace> fast_;
  MemoryRule memory_rule_;
};

/** \brief Codes the voxels of one stream's frames as payloads, or decodes them; keeps the
 * stream's history. An instance is for one direction only. After an exception it can
 * only be destroyed. */
class PayloadCoder {
public:
  virtual ~PayloadCoder() = default;

  /** \brief Finds which voxels of the next frame the history has a record of. encode() of
   * a P-frame needs this of the same voxels, with nothing coded in between.
   * \param[in,out] memory for the frame; that of encode()
   * \param[in] frame consistent; it may be without voxels
   * \return number of its voxels that have a record
   */
  virtual std::size_t
  match(CodingWorkspace& memory, const VoxelFrame& frame) = 0;

  /** \brief Appends the payload of the next frame of the stream, and learns the frame.
   * \param[in,out] memory for the frame
   * \param[in] frame consistent; it may be without voxels
   * \param[in] is_i_frame forget what was before; a P-frame is matched before
   * \param[in,out] payload where to append
   */
  virtual PayloadSizes
  encode(CodingWorkspace& memory,
         const VoxelFrame& frame,
         bool is_i_frame,
         std::vector<std::uint8_t>& payload) = 0;

  /** \brief Decodes what encode() appended. If that succeeds either learn() or discard()
   * has to follow; if it fails the history is as it was.
   * \param[in,out] memory for the frame, not to be used for others before learn() or
   * discard()
   * \param[in] begin first byte
   * \param[in] end end of the payload, all of which must be used
   * \param[in] voxel_count number of voxels of the frame
   * \param[in] is_i_frame as for encode
   * \param[in,out] frame its voxels are filled in; its other members are given
   * \param[out] sizes as encode returns
   * \return false if the bytes are no payload of that many voxels
   */
  virtual bool
  decode(CodingWorkspace& memory,
         const std::uint8_t* begin,
         const std::uint8_t* end,
         std::size_t voxel_count,
         bool is_i_frame,
         VoxelFrame& frame,
         PayloadSizes& sizes) = 0;

  /** \brief Learns the frame that was decoded last. */
  virtual void
  learn() noexcept = 0;

  /** \brief Leaves models and history as they were before the frame that was decoded
   * last. */
  virtual void
  discard() noexcept = 0;

  /** \brief Gives back the memory that models and history do not need. */
  virtual void
  giveBackMemory() = 0;

  /** \brief Number of voxels that the history has a record of. */
  virtual std::size_t
  recordCount() const = 0;
};

/** \brief The coders of one stream by effort, each made when it is first asked for. */
class PayloadCoders {
public:
  /** \brief The coder of an effort. */
  PayloadCoder&
  of(Effort effort);

  /** \brief Records of the coder of an effort, if there is one. */
  std::size_t
  recordCount(Effort effort) const;

  /** \brief Ends all coders but that of an effort. */
  void
  keepOnly(Effort effort) noexcept;

  /** \brief Ends all coders, and with them their histories. */
  void
  clear() noexcept;

private:
  std::array<std::unique_ptr<PayloadCoder>, 3> coders_;
};

} // namespace io
} // namespace pcl_ext

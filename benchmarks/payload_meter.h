/** \file
 * \brief Decodes the payloads of the context family with a meter.
 */
#pragma once

#include "bytes/byte_source.h"
#include "codec/context/frame_blocks.h"
#include "codec/context/history.h"
#include "codec/context/intensities.h"
#include "codec/context/new_blocks.h"
#include "codec/context/new_voxels.h"
#include "codec/context/tracked_voxels.h"
#include "codec/depth_split.h"
#include "codec/point_symbols.h"
#include "entropy_meter.h"
#include "stream/version1_header.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Measures the frames of a stream, which it decodes with the library's passes
 * (codec/context/payload.h). Supplements are skipped.
 * \tparam IsSmall effort small; else balanced
 */
template <bool IsSmall>
class PayloadMeter {
public:
  PayloadMeter()
  {
    meter_.assign(&models_.tracked_voxels.voxel, tracked_voxels);
    meter_.assign(&models_.new_voxels.block, tracked_blocks);
    meter_.assign(&models_.new_voxels.cell, new_voxels);
    meter_.assign(&models_.children.child, new_blocks);
  }

  /** \brief Measures the next frame.
   * \param[in] bytes an encoder's frame
   * \return size of its supplement, bytes
   * \throws std::runtime_error if it does not decode
   */
  std::size_t
  add(const std::vector<std::uint8_t>& bytes)
  {
    readHeader(bytes);
    const std::uint8_t* const end = bytes.data() + bytes.size();
    const std::uint8_t* begin = end - header_.payload_size;
    readDepthModel(begin);
    const bool is_refined = header_.content.refinement_levels > 0;
    const auto voxels = static_cast<std::size_t>(is_refined ? header_.coarse_voxel_count
                                                            : header_.voxel_count);
    if (!decode(begin, end - header_.supplement_size, voxels))
      throw std::runtime_error("a frame does not decode while it is measured");
    return static_cast<std::size_t>(header_.supplement_size);
  }

  std::array<Figures, part_count>
  result() const
  {
    return meter_.result();
  }

private:
  using Coding = MeteredCoding<IsSmall>;

  struct Models {
    io::context::TrackedVoxelModels tracked_voxels{IsSmall};
    io::context::NewVoxelModels new_voxels{IsSmall};
    io::context::ChildModels children{IsSmall};
    io::context::IntensityContexts intensity{IsSmall};
    io::context::IntensityContexts points{IsSmall}; // beside intensities
  };

  void
  readHeader(const std::vector<std::uint8_t>& bytes)
  {
    io::MemoryBuffer buffer(bytes.data(), bytes.size());
    io::ByteSource source(buffer, bytes.size());
    source.skip(io::version1_magic_size);
    io::Version1Header header;
    std::uint32_t checksum = 0;
    std::vector<std::uint8_t> checked_bytes;
    const io::CompressionStatus status = io::readVersion1Header(
        source, io::DecoderLimits(), header, checksum, checked_bytes);
    if (!status.ok())
      throw std::runtime_error(status.message());
    if (!header.is_i_frame) {
      header.grid = header_.grid;
      header.intensity_scale = header_.intensity_scale;
    }
    header_ = header;
  }

  void
  readDepthModel(const std::uint8_t*& payload)
  {
    if (header_.is_i_frame)
      depth_model_.reset();
    if (!header_.has_depth_model)
      return;
    io::readDepthModel(payload, depth_model_.emplace());
    payload += io::depth_model_size;
    constexpr double bits = 8.0 * io::depth_model_size;
    meter_.begin(residuals);
    meter_.add(coded, bits);
    meter_.add(ideal, bits);
    meter_.addPlain(bits);
  }

  /** \brief Decodes a payload and learns the frame. \return false if it is not valid */
  bool
  decode(const std::uint8_t* begin, const std::uint8_t* end, std::size_t voxels)
  {
    const unsigned int levels = header_.content.refinement_levels;
    const bool has_intensities = levels == 0 && header_.intensity_scale.bits > 0;
    const bool has_points = levels == 0 && header_.content.has_point_counts;
    const unsigned int symbol_bits = has_intensities ? header_.intensity_scale.bits
                                     : has_points    ? io::point_symbol_bits
                                                     : 0;
    if (header_.is_i_frame)
      models_ = Models();
    blocks_.clear();
    intensities_.base_symbols.assign(voxels, 0);
    intensities_.symbols.assign(voxels, 0);
    Coding coding(io::context::BinaryRangeDecoder(begin, end), meter_);
    meter_.begin(history_use);
    const bool uses_history =
        !header_.is_i_frame && (voxels == 0 || coding.codeBypass(false));
    if (!uses_history)
      history_.clear(symbol_bits);
    const io::context::FrameParameters parameters{history_,
                                                  header_.grid.depth - levels,
                                                  symbol_bits,
                                                  depth_model_ ? &*depth_model_
                                                               : nullptr};
    const bool is_valid =
        voxels == 0
            ? begin == end
            : decodeVoxels(coding, parameters) &&
                  decodeIntensities(coding, parameters) &&
                  (!has_points || decodePoints(coding, parameters, has_intensities)) &&
                  coding.coder().isAtEnd();
    // The rest of the last bytes.
    meter_.add(coded,
               8.0 * (static_cast<double>(end - begin) -
                      static_cast<double>(coding.coder().settledBytes())));
    io::DepthObservations depths;
    const bool has_depths = depth_model_ && voxels != 0;
    if (has_depths)
      intensities_.split.observe(
          intensities_.base_symbols, intensities_.symbols, depths);
    history_.update(blocks_,
                    intensities_.base_symbols,
                    has_depths ? &depths : nullptr,
                    !uses_history,
                    has_points && has_intensities ? &intensities_.point_symbols
                                                  : nullptr);
    return is_valid;
  }

  bool
  decodeVoxels(Coding& coding, const io::context::FrameParameters& parameters)
  {
    frame_.begin(parameters.history);
    const std::size_t voxels = intensities_.base_symbols.size();
    const std::size_t tracked = io::context::TrackedVoxelPass(
                                    coding, models_.tracked_voxels, frame_, parameters)
                                    .run();
    if (tracked > voxels)
      return false;
    io::context::NewVoxelPass in_tracked_blocks(
        coding, models_.new_voxels, frame_, parameters, voxels - tracked);
    if (!in_tracked_blocks.run())
      return false;
    meter_.begin(new_blocks);
    if (!io::context::NewBlockPass(coding,
                                   models_.children,
                                   frame_,
                                   parameters,
                                   voxels - tracked - in_tracked_blocks.voxelCount())
             .run())
      return false;
    frame_.collect(parameters.history, blocks_);
    return blocks_.voxelCount() == voxels;
  }

  /** \brief Decodes numbers of points, of which the symbols may have been the first ones. */
  bool
  decodePoints(Coding& coding,
               const io::context::FrameParameters& parameters,
               bool has_intensities)
  {
    meter_.begin(points);
    const io::context::FrameParameters point_parameters{
        parameters.history, parameters.grid_depth, io::point_symbol_bits, nullptr};
    io::context::IntensityPass<Coding> pass(coding,
                                            has_intensities ? models_.points
                                                            : models_.intensity,
                                            frame_.directory,
                                            point_parameters);
    intensities_.point_symbols = intensities_.symbols;
    if (has_intensities)
      pass.run(blocks_, intensities_.point_symbols, parameters.history.pointRecords());
    std::vector<std::uint32_t> counts(intensities_.point_symbols.begin(),
                                      intensities_.point_symbols.end());
    return pass.codeExcess(counts);
  }

  bool
  decodeIntensities(Coding& coding, const io::context::FrameParameters& parameters)
  {
    using Pass = io::context::IntensityPass<Coding>;
    io::context::IntensityContexts& models = models_.intensity;
    meter_.begin(numbers);
    if (parameters.symbol_bits != 0)
      Pass(coding, models, frame_.directory, parameters)
          .run(blocks_, intensities_.base_symbols);
    intensities_.symbols = intensities_.base_symbols;
    if (parameters.depth_model == nullptr)
      return true;
    meter_.begin(residuals);
    parameters.history.predictDepths(blocks_, intensities_.predictions);
    intensities_.split.begin(*parameters.depth_model,
                             blocks_,
                             intensities_.predictions,
                             parameters.maxSymbol());
    intensities_.split.predict(intensities_.base_symbols);
    return Pass(coding, models, frame_.directory, parameters)
        .codeResiduals(intensities_.split, intensities_.symbols);
  }

  EntropyMeter meter_;
  Models models_;
  io::context::History history_;
  std::optional<io::DepthModel> depth_model_;
  // Of the current frame.
  io::Version1Header header_; // of a P-frame with the I-frame's grid and scale
  io::BlockList blocks_;
  io::context::FrameBlocks frame_;
  io::context::CodedIntensities intensities_;
};

} // namespace measuring
} // namespace pcl_ext

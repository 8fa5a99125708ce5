#pragma once

#include "codec/fast/entropy_coder.h"
#include "codec/fast/frame.h"
#include "codec/fast/models.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Codes the intensity symbols of a frame (doc/bitstream_fast.md, "Symbols"),
 * grouped by what is known of them: voxels with a low mean, four at a time, other voxels
 * with a mean, voxels without; then steps that did not fit, then the bits within steps.
 *
 * A Coder is NibbleEncoder or NibbleDecoder; a Symbol is constant for an encoder.
 */
class Intensities {
public:
  /** \brief Codes the symbols and learns them.
   * \param[in] frame its blocks and voxels
   * \param[in,out] moments those of the history, 64 a block
   * \param[in] bits of a symbol, 1..16
   * \param[in] symbols one for each voxel
   */
  void
  encode(NibbleEncoder& coder,
         Models& models,
         const Frame& frame,
         Moments& moments,
         unsigned int bits,
         const std::vector<std::uint16_t>& symbols);

  /** \brief The reverse.
   * \return false if the bytes are no such symbols; `forget` undoes what was learnt
   */
  bool
  decode(NibbleDecoder& coder,
         Models& models,
         const Frame& frame,
         Moments& moments,
         unsigned int bits,
         std::vector<std::uint16_t>& symbols);

  /** \brief Gives the moments back as they were before the last `code`. */
  void
  forget(const Frame& frame, Moments& moments);

private:
  /** \brief Voxels that are coded alike, in Morton order. The vector is memory, of
   * which the first `count` elements are in use; once they are coded it is the first
   * `noted`, those of which more is to be coded. */
  struct Row {
    std::vector<std::uint32_t> voxels; ///< their index in the frame
    std::size_t count = 0;
    std::size_t noted = 0;
  };

  template <class Coder, class Symbol>
  bool
  code(Coder& coder,
       Models& models,
       const Frame& frame,
       std::uint16_t* moments,
       Symbol* symbols);

  void
  encodeExpected(NibbleEncoder& coder,
                 Models& models,
                 const Frame& frame,
                 Moments& moments,
                 unsigned int bits,
                 const std::vector<std::uint16_t>& symbols);

  template <class Coder, class Symbol>
  static bool
  codePlain(Coder& coder,
            Models& models,
            unsigned int bits,
            std::size_t count,
            Symbol* symbols);

  void
  sortIntoRows(const Frame& frame, const Moments& moments);

  void
  splitNewVoxels(bool in_quads);

  bool
  areSymbols(const std::vector<std::uint16_t>& symbols) const;

  void
  setOrigin(unsigned int origin, unsigned int bits);

  template <class Coder, class Symbol>
  bool
  codeQuads(Coder& coder,
            Models& models,
            unsigned int low_class,
            std::uint16_t* moments,
            Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeKnown(Coder& coder, Models& models, std::uint16_t* moments, Symbol* symbols);

  template <bool is_decoder, class Symbol>
  void
  learnKnown(std::uint16_t* moments, Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeNew(Coder& coder,
          Models& models,
          bool is_i_frame,
          std::uint16_t* moments,
          Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeHighQuadSteps(Coder& coder,
                    Models& models,
                    unsigned int low_class,
                    std::uint16_t* moments,
                    Symbol* symbols);

  template <class Coder, class Symbol>
  bool
  codeNotedSteps(Coder& coder, Models& models, std::uint16_t* moments, Symbol* symbols);

  template <class Coder>
  bool
  codeWholeStep(Coder& coder,
                Models& models,
                unsigned int lowest,
                unsigned int value,
                unsigned int& step);

  template <class Coder>
  bool
  codeValue(Coder& coder, unsigned int step, unsigned int& value);

  unsigned int
  stepOf(unsigned int value) const;

  /** \brief Classes of voxels with a low mean, and those without a moment. */
  static constexpr unsigned int low_class_count = 4;
  static constexpr unsigned int without_moment = 3;

  std::vector<std::uint16_t> before_;  ///< by voxel: its moment before this frame
  Models models_before_;               ///< an encoder's, before this frame
  const VoxelPlace* places_ = nullptr; ///< those of the frame
  std::array<Row, low_class_count> quads_;
  Row known_;
  Row new_;
  // Of the row that is coded.
  std::vector<std::uint8_t> contexts_;
  std::vector<std::uint8_t> coded_;
  std::vector<std::uint16_t> known_moments_;
  unsigned int origin_ = 0;       // lowest value that is coded
  unsigned int top_ = 0;          // highest one, less the origin
  unsigned int top_step_ = 0;     // its step if it has one of its own, else above all
  unsigned int highest_step_ = 0; // highest that may occur
};

} // namespace fast
} // namespace io
} // namespace pcl_ext

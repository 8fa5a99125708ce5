#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/context/history.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Splits intensity symbols that depend on depth into a number of points, which
 * is coded like a count, and a small rest (doc/bitstream.md, "Depth model").
 *
 * A voxel of n points at depth z has the intensity n I_p(z), but for the points' places
 * in the voxel: the depth offset, which the history remembers, as a surface stays where
 * it is. Integers only.
 */
class DepthSplit {
public:
  /** \brief A voxel whose symbol is its number: a point there is worth less than one
   * symbol, so that the number of points cannot be told from it. */
  static constexpr std::uint8_t no_rest = 0xff;

  /** \brief Classes of rests are below this. */
  static constexpr std::uint8_t class_count = 192;

  /** \brief Begins with a frame.
   * \param[in] model what a point is worth
   * \param[in] frame the frame's blocks
   * \param[in] history of the frames before
   * \param[in] max_symbol the highest symbol
   */
  void
  begin(const DepthModel& model,
        const BlockList& frame,
        const context::History& history,
        std::uint32_t max_symbol);

  /** \brief The numbers of points, of the symbols; the encoder's. */
  void
  numbersOf(const std::vector<std::uint16_t>& symbols,
            std::vector<std::uint16_t>& numbers) const;

  /** \brief Predicts the symbols from the numbers: classes() is known then. */
  void
  predict(const std::vector<std::uint16_t>& numbers);

  /** \brief The class of each voxel's rest, or no_rest. */
  const std::vector<std::uint8_t>&
  classes() const
  {
    return classes_;
  }

  /** \brief Where in its symbol a voxel's prediction is, 0..15, and the bit length of half
   * the symbol, 0..7, in one number below 128. */
  std::uint32_t
  place(std::size_t voxel) const
  {
    return places_[voxel];
  }

  /** \brief Class of a voxel's number of points, 0..3. */
  std::uint32_t
  pointClass(std::size_t voxel) const
  {
    return point_classes_[voxel];
  }

  /** \brief The rest of a voxel: 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ... */
  std::uint32_t
  rest(std::size_t voxel, std::uint16_t symbol) const
  {
    const std::int32_t distance = static_cast<std::int32_t>(symbol) -
                                  static_cast<std::int32_t>(predicted_[voxel]);
    return distance < 0 ? static_cast<std::uint32_t>(-2 * distance - 1)
                        : static_cast<std::uint32_t>(2 * distance);
  }

  /** \brief The symbol that a rest leads to.
   * \param[in] voxel index of the voxel
   * \param[in] rest as rest() counts
   * \param[out] symbol the symbol
   * \return false if there is no such symbol
   */
  bool
  symbol(std::size_t voxel, std::uint32_t rest, std::uint16_t& symbol) const;

  /** \brief What the history is to remember of each voxel, once the symbols are known.
   */
  void
  observe(const std::vector<std::uint16_t>& numbers,
          const std::vector<std::uint16_t>& symbols,
          context::DepthObservations& depths) const;

private:
  std::uint32_t max_symbol_ = 0;
  // Of each voxel what a point adds to the symbol, in 2^-16: at the centre, and with the
  // depth offset; and the class of its roughness.
  std::vector<std::uint64_t> centre_symbols_;
  std::vector<std::uint64_t> point_symbols_;
  std::vector<std::uint8_t> roughness_;
  std::vector<std::uint16_t> predicted_; // symbols
  std::vector<std::uint8_t> classes_;
  std::vector<std::uint8_t> places_;
  std::vector<std::uint8_t> point_classes_;
};

} // namespace io
} // namespace pcl_ext

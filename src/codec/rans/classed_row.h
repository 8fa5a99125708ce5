// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/nibble_model.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

/** \brief Codes rows of small numbers, each with a class that encoder and decoder know,
 * such as the residuals of a depth model (doc/bitstream_fast.md, "Classed rows"). Each
 * class has an adaptive model of numbers up to 14; larger ones are escaped.
 */
class ClassedRow {
public:
  static constexpr std::size_t class_count = 16;

  /** \brief Appends a row and adapts the models.
   * \param[in] is_first start with initial models, as at an I-frame
   * \param[in] numbers the row, any length; the length is not written
   * \param[in] classes as many classes, 0..15
   * \param[in,out] bytes where to append
   */
  void
  encode(bool is_first,
         const std::vector<std::uint16_t>& numbers,
         const std::vector<std::uint8_t>& classes,
         std::vector<std::uint8_t>& bytes);

  /** \brief Reads a row; learn() then adapts the models.
   * \param[in] begin first byte
   * \param[in] end one past the last byte
   * \param[in] is_first as for `encode`
   * \param[in] classes as for `encode`; their number is that of the row
   * \param[out] numbers the row
   * \return false if the bytes are not what `encode` writes
   */
  bool
  decode(const std::uint8_t* begin,
         const std::uint8_t* end,
         bool is_first,
         const std::vector<std::uint8_t>& classes,
         std::vector<std::uint16_t>& numbers);

  /** \brief Adapts the models to the row that was decoded last. */
  void
  learn() noexcept
  {
    models_ = next_models_;
  }

  /** \brief Releases the memory of the last row. */
  void
  releaseMemory()
  {
    work_ = Workspace();
  }

  /** \brief Returns to the initial models, as at an I-frame. */
  void
  reset() noexcept
  {
    models_ = Models();
  }

private:
  struct Models {
    std::array<NibbleModel, class_count> number;
    NibbleModel length; // bits of an escaped number
  };

  template <class Coder>
  static bool
  code(Coder& coder,
       Models& models,
       const std::vector<std::uint8_t>& classes,
       std::uint16_t* numbers);

  Models models_;
  Models next_models_;
  /** \brief Scratch of the current row; a member so that its memory is reused. */
  struct Workspace {
    std::vector<std::uint16_t> numbers;
    std::vector<std::uint32_t> ranges;
    std::vector<std::uint16_t> words;
    std::vector<std::uint8_t> bytes;
  };
  Workspace work_;
};

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>

#include "codec/supplement/field_numbers.h"
#include "codec/supplement/fields.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief What a number is expected from. */
enum ExpectedFrom : std::size_t {
  from_neighbours,
  from_azimuth,
  from_elevation,
  from_past
};
constexpr std::size_t source_count = 4;

/** \brief Chooses among expectations by how large their errors were. */
class Expectation {
public:
  std::uint64_t&
  at(std::size_t source)
  {
    return numbers_[source];
  }

  void
  setKnown(std::size_t source, bool is_known)
  {
    is_known_[source] = is_known;
  }

  /** \brief Chooses the one with the smallest error; from_neighbours is always known.
   * \param[out] context for the length of the residual
   */
  std::uint64_t
  choose(std::size_t& context) const
  {
    const std::size_t best = bestBut(source_count);
    const std::size_t second = bestBut(best);
    const unsigned int spread =
        second == source_count
            ? 0
            : bitLength(foldDifference(numbers_[best], numbers_[second]));
    const std::size_t activity = std::min<std::size_t>(
        (errors_[best] + 64) >> 7, FieldState::activity_classes - 1);
    context = activity * FieldState::spread_classes +
              std::min<std::size_t>(spread, FieldState::spread_classes - 1);
    return numbers_[best];
  }

  void
  learn(std::uint64_t number)
  {
    for (std::size_t source = 0; source < source_count; ++source)
      if (is_known_[source])
        errors_[source] += 16 * bitLength(foldDifference(number, numbers_[source])) -
                           errors_[source] / 16;
  }

private:
  /** \brief The known one with the smallest error, the first of equals; source_count if
   * there is none.
   * \param[in] excluded is not taken
   */
  std::size_t
  bestBut(std::size_t excluded) const
  {
    std::size_t best = source_count;
    std::uint32_t error = ~std::uint32_t{0};
    for (std::size_t source = 0; source < source_count; ++source)
      if (is_known_[source] && source != excluded && errors_[source] < error) {
        best = source;
        error = errors_[source];
      }
    return best;
  }

  std::array<std::uint64_t, source_count> numbers_{};
  std::array<bool, source_count> is_known_{};
  /** \brief 256 times the mean length of the last residuals, sixteen or so. */
  std::array<std::uint32_t, source_count> errors_{1024, 1024, 1024, 1024};
};

/** \brief Codes the numbers of one field of a frame. */
template <class CodingT>
class FieldPass {
public:
  FieldPass(const FieldDescription& field, FieldState& state, const FieldPlaces& places)
  : state_(state), places_(places), count_(field.count), zero_(numberOfZero(field))
  {}

  /** \brief Codes which numbers there are, if they are few, and the numbers.
   * \param[in,out] indices scratch memory
   * \param[in,out] numbers of all points; the decoder sets them
   */
  template <class NumbersT>
  bool
  run(CodingT& coding, std::vector<std::uint64_t>& indices, NumbersT& numbers)
  {
    CodingT local = coding; // in registers
    const bool is_whole =
        count_ == 1 ? codeSingle(local, indices, numbers) : codeTuples(local, numbers);
    coding = local;
    return is_whole;
  }

private:
  static std::uint64_t
  numberOfZero(const FieldDescription& field)
  {
    const std::uint64_t zero = 0; // of any type
    return fieldNumber(field, &zero);
  }

  template <class NumbersT>
  bool
  codeSingle(CodingT& coding, std::vector<std::uint64_t>& indices, NumbersT& numbers)
  {
    const bool had_dictionary = state_.has_dictionary;
    std::vector<std::uint64_t> dictionary;
    if constexpr (!CodingT::is_decoder)
      makeDictionary(numbers, dictionary, indices);
    if (!codeDictionary(coding, numbers.size(), dictionary))
      return false;
    if (had_dictionary != state_.has_dictionary) {
      state_.by_azimuth = {};
      state_.by_elevation = {};
      state_.last.clear();
    }
    if (!state_.has_dictionary)
      return codeNumbers(coding, zero_, numbers);
    indices.resize(numbers.size());
    if (!codeNumbers(coding, 0, indices))
      return false;
    if constexpr (CodingT::is_decoder)
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (indices[i] >= state_.dictionary.size())
          return false;
        numbers[i] = state_.dictionary[static_cast<std::size_t>(indices[i])];
      }
    return true;
  }

  /** \brief Lists all numbers, if they are few in a wide range.
   * \param[out] dictionary the numbers, ascending; else empty
   * \param[out] indices of all numbers in it
   */
  static void
  makeDictionary(const std::vector<std::uint64_t>& numbers,
                 std::vector<std::uint64_t>& dictionary,
                 std::vector<std::uint64_t>& indices)
  {
    const auto [lowest, highest] = std::minmax_element(numbers.begin(), numbers.end());
    constexpr std::uint64_t narrow = 64;
    if (*highest - *lowest < narrow)
      return;
    constexpr unsigned int table_bits = 16;
    constexpr std::size_t slots = std::size_t{1} << table_bits;
    const std::size_t most = std::min(numbers.size() / 4, slots / 2);
    std::vector<std::uint16_t> table(slots); // place in the dictionary + 1
    indices.resize(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      auto slot = static_cast<std::size_t>(numbers[i] * 0x9E3779B97F4A7C15 >>
                                           (64 - table_bits));
      while (table[slot] != 0 && dictionary[table[slot] - 1u] != numbers[i])
        slot = (slot + 1) % slots;
      if (table[slot] == 0) {
        if (dictionary.size() >= most) {
          dictionary.clear();
          return;
        }
        dictionary.push_back(numbers[i]);
        table[slot] = static_cast<std::uint16_t>(dictionary.size());
      }
      indices[i] = table[slot] - 1u;
    }
    if ((*highest - *lowest) / 4 < dictionary.size()) {
      dictionary.clear();
      return;
    }
    const std::vector<std::uint64_t> by_first_place = dictionary;
    std::sort(dictionary.begin(), dictionary.end());
    std::vector<std::uint64_t> ranks;
    for (const std::uint64_t number : by_first_place)
      ranks.push_back(static_cast<std::uint64_t>(
          std::lower_bound(dictionary.begin(), dictionary.end(), number) -
          dictionary.begin()));
    for (std::uint64_t& index : indices)
      index = ranks[static_cast<std::size_t>(index)];
  }

  /** \brief Codes the numbers that there are.
   * \param[in] dictionary of an encoder; empty: none
   */
  bool
  codeDictionary(CodingT& coding,
                 std::size_t number_count,
                 const std::vector<std::uint64_t>& dictionary)
  {
    coding.reserve(2 + most_wide_symbols);
    state_.has_dictionary = coding.codeBits(dictionary.empty() ? 0 : 1, 1) != 0;
    if (!state_.has_dictionary) {
      state_.dictionary.clear();
      return !coding.isOverrun();
    }
    const bool is_same =
        coding.codeBits(dictionary == state_.dictionary ? 1 : 0, 1) != 0;
    if (is_same)
      return !coding.isOverrun() && !state_.dictionary.empty();
    std::uint64_t size = dictionary.size();
    if (!codeWide(coding, state_.dictionary_lengths, state_.wide, size) || size == 0 ||
        size > number_count)
      return false;
    state_.dictionary.resize(static_cast<std::size_t>(size));
    std::uint64_t last = 0;
    std::uint64_t gap = 0;
    for (std::size_t i = 0; i < state_.dictionary.size(); ++i) {
      coding.reserve(most_wide_symbols);
      std::uint64_t folded =
          CodingT::is_decoder ? 0 : foldDifference(dictionary[i] - last, gap);
      if (!codeWide(coding, state_.dictionary_lengths, state_.wide, folded))
        return false;
      gap = unfoldDifference(folded, gap);
      last += gap;
      state_.dictionary[i] = last;
    }
    return true;
  }

  /** \brief Codes single values.
   * \param[in] start what is expected before there is any
   */
  template <class NumbersT>
  bool
  codeNumbers(CodingT& coding, std::uint64_t start, NumbersT& numbers)
  {
    const std::size_t voxels = places_.directions.size();
    std::uint64_t last = start;
    Expectation expectation;
    expectation.setKnown(from_neighbours, true);
    for (std::size_t voxel = 0; voxel < voxels; ++voxel) {
      const Direction direction = places_.directions[voxel];
      const std::uint32_t before = places_.before[voxel];
      const bool has_past = before != 0 && before <= state_.last.size();
      expectation.setKnown(from_past, has_past);
      if (has_past)
        expectation.at(from_past) = state_.last[before - 1];
      expectation.at(from_neighbours) = aroundOf(voxel, numbers, last);
      const std::uint32_t end = places_.first_points[voxel + 1];
      for (std::uint32_t i = places_.first_points[voxel]; i < end; ++i) {
        expectation.setKnown(
            from_azimuth,
            state_.by_azimuth.expect(direction.azimuth, expectation.at(from_azimuth)));
        expectation.setKnown(from_elevation,
                             state_.by_elevation.expect(
                                 direction.elevation, expectation.at(from_elevation)));
        std::size_t context = 0;
        const std::uint64_t expected = expectation.choose(context);
        coding.reserve(most_wide_symbols);
        std::uint64_t folded =
            CodingT::is_decoder ? 0 : foldDifference(numbers[i], expected);
        if (!codeWide(coding, state_.lengths[context], state_.wide, folded))
          return false;
        last = unfoldDifference(folded, expected);
        if constexpr (CodingT::is_decoder)
          numbers[i] = last;
        expectation.learn(last);
        state_.by_azimuth.set(direction.azimuth, last);
        state_.by_elevation.set(direction.elevation, last);
        expectation.at(from_neighbours) = last;
      }
    }
    state_.last.resize(voxels);
    for (std::size_t voxel = 0; voxel < voxels; ++voxel)
      state_.last[voxel] = numbers[places_.first_points[voxel]];
    return true;
  }

  /** \brief The mean of the first numbers of a voxel's lower neighbours, without those
   * far from the first one; of none, the last number. */
  template <class NumbersT>
  std::uint64_t
  aroundOf(std::size_t voxel, const NumbersT& numbers, std::uint64_t last) const
  {
    std::uint64_t first = 0;
    std::int64_t sum = 0;
    std::int64_t count = 0;
    for (const std::uint32_t lower : places_.lower[voxel]) {
      if (lower == voxel)
        continue;
      const std::uint64_t number = numbers[places_.first_points[lower]];
      first = count == 0 ? number : first;
      const auto difference = static_cast<std::int64_t>(number - first);
      constexpr std::int64_t far = std::int64_t{1} << 60;
      if (difference < far && difference > -far) {
        sum += difference;
        ++count;
      }
    }
    return count == 0 ? last : first + static_cast<std::uint64_t>(sum / count);
  }

  /** \brief Codes several values of each point, each as a residual of the same one of
   * the neighbours. */
  template <class NumbersT>
  bool
  codeTuples(CodingT& coding, NumbersT& numbers)
  {
    const std::size_t voxels = places_.directions.size();
    std::uint32_t error = 1024;
    std::size_t beside = numbers.size(); // the point that values are expected from
    for (std::size_t voxel = 0; voxel < voxels; ++voxel) {
      for (const std::uint32_t lower : places_.lower[voxel])
        if (lower != voxel)
          beside = places_.first_points[lower] * count_;
      const std::uint32_t end = places_.first_points[voxel + 1];
      for (std::uint32_t i = places_.first_points[voxel]; i < end; ++i) {
        const std::size_t begin = i * count_;
        for (std::size_t k = 0; k < count_; ++k) {
          const std::uint64_t expected =
              beside == numbers.size() ? zero_ : numbers[beside + k];
          const std::size_t activity = std::min<std::size_t>(
              (error + 64) >> 7, FieldState::activity_classes - 1);
          coding.reserve(most_wide_symbols);
          std::uint64_t folded =
              CodingT::is_decoder ? 0 : foldDifference(numbers[begin + k], expected);
          if (!codeWide(coding,
                        state_.lengths[activity * FieldState::spread_classes],
                        state_.wide,
                        folded))
            return false;
          if constexpr (CodingT::is_decoder)
            numbers[begin + k] = unfoldDifference(folded, expected);
          error += 16 * bitLength(folded) - error / 16;
        }
        beside = begin;
      }
    }
    return true;
  }

  FieldState& state_;
  const FieldPlaces& places_;
  std::size_t count_;
  std::uint64_t zero_;
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io

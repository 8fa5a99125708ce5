/** \file
 * \brief Measures the decisions of the context family while a payload is decoded.
 */
#pragma once

#include "codec/context/entropy_coder.h"
#include "codec/context/models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief What the decisions of a payload say. */
enum Part : std::size_t {
  history_use,
  tracked_voxels,
  tracked_blocks,
  new_voxels,
  new_blocks,
  numbers,
  residuals,
  points,
  part_count
};

/** \brief Figures of a part: bits, and the number of decisions with a model.
 *
 * Adaptive: with the estimate (n1 + 1/2) / (n + 1) from all decisions before in the
 * same context (Krichevsky and Trofimov, The performance of universal encoding, 1981).
 * Fixed: with the frequencies known in advance, the conditional entropy.
 * First: by the first context of each decision. Best: by that of a model's contexts
 * that takes the fewest bits. Joint: by all contexts of a decision together. Choices
 * (ChoiceModel) have no contexts: all of these are as ideal.
 */
enum Figure : std::size_t {
  coded, ///< in the payload
  ideal, ///< by the coder's own probabilities
  adaptive_first,
  adaptive_best,
  adaptive_joint,
  fixed_first,
  fixed_best,
  fixed_joint,
  decisions,
  figure_count
};
using Figures = std::array<double, figure_count>;

/** \brief How often a decision was 0 and 1 in a context. */
struct DecisionCounts {
  double zeros = 0.0;
  double ones = 0.0;

  void
  add(bool bit)
  {
    (bit ? ones : zeros) += 1.0;
  }

  /** \brief The product of all estimates, G(n0 + 1/2) G(n1 + 1/2) / (pi G(n + 1)), in
   * bits; it does not depend on the order. */
  double
  adaptiveBits() const
  {
    return (std::lgamma(zeros + ones + 1.0) + 2.0 * std::lgamma(0.5) -
            std::lgamma(zeros + 0.5) - std::lgamma(ones + 0.5)) /
           std::log(2.0);
  }

  double
  fixedBits() const
  {
    double bits = 0.0;
    for (const double count : {zeros, ones})
      bits += count > 0.0 ? count * std::log2((zeros + ones) / count) : 0.0;
    return bits;
  }
};

/** \brief Counts the decisions of a stream, by part, model and context. */
class EntropyMeter {
public:
  /** \brief Sets the part of what follows, unless its model is assigned to one. */
  void
  begin(Part part)
  {
    part_ = part;
  }

  /** \brief Assigns a model, as an address, to a part. */
  void
  assign(const void* model, Part part)
  {
    parts_[model] = part;
  }

  /** \brief To be called before a decision of a model. */
  void
  enter(const void* model)
  {
    const auto found = parts_.find(model);
    if (found != parts_.end())
      part_ = found->second;
  }

  void
  add(Figure figure, double bits)
  {
    figures_[part_][figure] += bits;
  }

  /** \brief Adds bits of what has no contexts. */
  void
  addPlain(double bits)
  {
    for (std::size_t figure = adaptive_first; figure <= fixed_joint; ++figure)
      figures_[part_][figure] += bits;
  }

  /** \brief Counts a decision.
   * \param[in] model as an address
   * \param[in] contexts those that are used, as an index in each row
   */
  void
  count(const void* model, const std::vector<std::uint32_t>& contexts, bool bit)
  {
    ModelCounts& counts = models_[{part_, model}];
    counts.ways.resize(contexts.size());
    std::uint64_t hash = 0; // that two of them are the same is as good as excluded
    for (std::size_t way = 0; way < contexts.size(); ++way) {
      std::vector<DecisionCounts>& row = counts.ways[way];
      row.resize(std::max(row.size(), contexts[way] + std::size_t{1}));
      row[contexts[way]].add(bit);
      hash = (hash ^ contexts[way]) * 0x9e3779b97f4a7c15;
      hash ^= hash >> 32;
    }
    counts.joint[hash].add(bit);
    add(decisions, 1.0);
  }

  /** \brief The figures of all parts so far. */
  std::array<Figures, part_count>
  result() const
  {
    std::array<Figures, part_count> result = figures_;
    for (const auto& [key, counts] : models_) {
      Figures& figures = result[key.first];
      std::vector<double> adaptive;
      std::vector<double> fixed;
      for (const std::vector<DecisionCounts>& row : counts.ways) {
        adaptive.push_back(0.0);
        fixed.push_back(0.0);
        for (const DecisionCounts& context : row) {
          adaptive.back() += context.adaptiveBits();
          fixed.back() += context.fixedBits();
        }
      }
      figures[adaptive_first] += adaptive.front();
      figures[adaptive_best] += *std::min_element(adaptive.begin(), adaptive.end());
      figures[fixed_first] += fixed.front();
      figures[fixed_best] += *std::min_element(fixed.begin(), fixed.end());
      for (const auto& context : counts.joint) {
        figures[adaptive_joint] += context.second.adaptiveBits();
        figures[fixed_joint] += context.second.fixedBits();
      }
    }
    return result;
  }

private:
  struct ModelCounts {
    std::vector<std::vector<DecisionCounts>> ways; ///< by context
    std::unordered_map<std::uint64_t, DecisionCounts> joint;
  };

  Part part_ = history_use;
  std::map<const void*, Part> parts_;
  std::array<Figures, part_count> figures_{};
  std::map<std::pair<Part, const void*>, ModelCounts> models_;
};

/** \brief A range decoder that adds up what its bits take. */
class MeteredDecoder : public io::context::BinaryRangeDecoder {
public:
  MeteredDecoder(const io::context::BinaryRangeDecoder& coder, EntropyMeter& meter)
  : BinaryRangeDecoder(coder), meter_(&meter)
  {}

  bool
  code(bool bit, std::uint32_t probability)
  {
    const std::size_t before = settledBytes();
    const bool decision = BinaryRangeDecoder::code(bit, probability);
    meter_->add(coded, 8.0 * static_cast<double>(settledBytes() - before));
    meter_->add(ideal, 16.0 - std::log2(decision ? probability : 65536 - probability));
    return decision;
  }

  std::uint32_t
  beginShare(std::uint32_t total)
  {
    total_ = total;
    return BinaryRangeDecoder::beginShare(total);
  }

  void
  endShare(std::uint32_t begin, std::uint32_t size, bool is_last)
  {
    const std::size_t before = settledBytes();
    BinaryRangeDecoder::endShare(begin, size, is_last);
    meter_->add(coded, 8.0 * static_cast<double>(settledBytes() - before));
    const double bits = std::log2(static_cast<double>(total_) / size);
    meter_->add(ideal, bits);
    meter_->addPlain(bits);
    meter_->add(decisions, 1.0);
  }

private:
  EntropyMeter* meter_;
  std::uint32_t total_ = 0; // of the share that was begun
};

/** \brief The decoder's DecisionCoding, with each decision counted. */
template <bool IsSmall>
class MeteredCoding : public io::context::DecisionCoding<MeteredDecoder, IsSmall> {
public:
  using Coding = io::context::DecisionCoding<MeteredDecoder, IsSmall>;

  MeteredCoding(const io::context::BinaryRangeDecoder& coder, EntropyMeter& meter)
  : Coding(MeteredDecoder(coder, meter)), meter_(&meter)
  {}

  template <typename ModelT>
  bool
  code(ModelT& model, const typename ModelT::Contexts& contexts, bool bit)
  {
    meter_->enter(&model);
    const bool decision = Coding::code(model, contexts, bit);
    const auto begin = contexts.ways.begin();
    ways_.assign(begin, begin + ModelT::wayCount(IsSmall));
    meter_->count(&model, ways_, decision);
    return decision;
  }

  template <typename ModelT>
  bool
  codeFirst(ModelT& model, std::uint32_t context, bool bit)
  {
    meter_->enter(&model);
    const bool decision = Coding::codeFirst(model, context, bit);
    ways_.assign(1, context);
    // A member's address, as these decisions have other contexts than those of code().
    meter_->count(&model.shifts(), ways_, decision);
    return decision;
  }

  template <std::size_t ClassCount>
  io::context::Choice
  codeChoice(io::context::ChoiceModel<ClassCount>& model,
             const std::array<std::uint32_t, ClassCount>& counts,
             io::context::Choice choice)
  {
    meter_->enter(&model);
    return Coding::codeChoice(model, counts, choice);
  }

  bool
  codeBypass(bool bit)
  {
    meter_->addPlain(1.0);
    return Coding::codeBypass(bit);
  }

private:
  EntropyMeter* meter_;
  std::vector<std::uint32_t> ways_;
};

} // namespace measuring
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Coders of whole numbers, for all points of a cloud.
 */
#pragma once

#include "coders/stream_coder.h"
#include "meters/decoded_checks.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Points as whole numbers of edges. */
using WholePositions = std::vector<std::array<std::uint32_t, 3>>;

/** \brief A coder of whole numbers gets voxels of points, and decodes their centres, so
 * that no coordinate is more than half an edge away. */
class WholeNumberCoder : public StreamCoder {
public:
  /** \param[in] edge metres */
  WholeNumberCoder(std::string name, double edge);

  void
  encode(const InputFrame& frame) override;

  void
  decode() override;

  void
  check(const InputFrame& frame) override;

protected:
  virtual void
  encodePositions(const WholePositions& positions) = 0;

  virtual void
  decodePositions(WholePositions& positions) = 0;

private:
  /** \brief Edges from the origin, cut off. */
  double
  index(float coordinate) const;

  Lattice lattice_;
  std::array<double, 3> least_{}; ///< index of each axis
  WholePositions numbers_;
};

} // namespace measuring
} // namespace pcl_ext

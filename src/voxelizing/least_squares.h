// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <Eigen/Core>

namespace pcl_ext::PCL_EXT_ABI::io {

// Of any size, as a compiler takes seconds for each size of a decomposition.

/** \brief The solution of matrix * solution = right by least squares; of several the
 * smallest one.
 * \param[in] threshold pivots below this part of the largest one are 0; 0: those of
 * rounding errors
 */
Eigen::MatrixXd
solveLeastSquares(const Eigen::MatrixXd& matrix,
                  const Eigen::MatrixXd& right,
                  double threshold = 0.0);

/** \brief Eigenvalues of a symmetric matrix, the smallest first, and its eigenvectors,
 * each a column. */
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;

  explicit SymmetricEigen(const Eigen::MatrixXd& matrix);
};

} // namespace pcl_ext::PCL_EXT_ABI::io

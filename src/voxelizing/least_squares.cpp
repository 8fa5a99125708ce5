// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/least_squares.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace pcl_ext::PCL_EXT_ABI::io {

Eigen::MatrixXd
solveLeastSquares(const Eigen::MatrixXd& matrix,
                  const Eigen::MatrixXd& right,
                  double threshold)
{
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  if (threshold > 0.0)
    decomposition.setThreshold(threshold);
  decomposition.compute(matrix);
  return decomposition.solve(right);
}

SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& matrix)
{
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  values = solver.eigenvalues();
  vectors = solver.eigenvectors();
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Decompositions of dense matrices, which serve as independent references. They are compiled once,
// because Eigen's decompositions take long to compile.
#pragma once

#include <Eigen/Core>

namespace loomstone::test {

// Returns the eigenvalues of a symmetric matrix in ascending order.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric);
// Returns the orthonormal eigenvectors (columns) of a symmetric matrix, in the order of the
// eigenvalues.
Eigen::MatrixXd eigenvectors(const Eigen::MatrixXd& symmetric);
// Returns the square root of a symmetric positive semidefinite matrix.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& symmetric);
// Returns the matrix with orthonormal columns that is closest to `f`, which must have full column
// rank: the rotation R of the polar decomposition f = R U.
Eigen::MatrixXd polar_rotation(const Eigen::MatrixXd& f);
// Returns the solution of a x = b for an invertible matrix a.
Eigen::VectorXd solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace loomstone::test

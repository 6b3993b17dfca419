#include "tests/support/decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace loomstone::test {

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).eigenvalues();
}

Eigen::MatrixXd eigenvectors(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).eigenvectors();
}

Eigen::MatrixXd square_root(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).operatorSqrt();
}

Eigen::MatrixXd polar_rotation(const Eigen::MatrixXd& f) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(f, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::VectorXd solution(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.fullPivLu().solve(b);
}

}  // namespace loomstone::test

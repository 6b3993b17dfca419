// A symmetric positive definite system, generated from a fixed seed, that resembles the system of a
// time step. It has bodies, a grid of cloth rows, contact terms between random cloth rows and
// between cloth rows and bodies, and fixed rows with prescribed values.
#pragma once

#include <algorithm>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/linalg/linear_solver.h"
#include "core/linalg/matrix_halo.h"

namespace loomstone::testing {

struct RandomSystem {
  BlockMatrix matrix;
  std::vector<Mat3> body_blocks;
  ExtraTerms terms;
  std::vector<std::uint8_t> fixed;
  std::unique_ptr<RowLayout> layout;
  Halo halo;
  Points b, x;

  LinearSystem view() const {
    LinearSystem system;
    system.matrix = &matrix;
    system.body_blocks = &body_blocks;
    system.terms = &terms;
    system.term_scale = 0.5;
    system.fixed = &fixed;
    system.layout = layout.get();
    system.halo = &halo;
    return system;
  }
};

class RandomSystemBuilder {
 public:
  RandomSystemBuilder(Index side, int n_bodies, int n_terms,
                      std::shared_ptr<const Communicator> communicator)
      : side_(side), n_cloth_(side * side), n_rows_(n_cloth_ + 2 * n_bodies) {
    made_.layout = std::make_unique<RowLayout>(n_rows_, std::move(communicator));
    springs();
    for (int i = 0; i < 2 * n_bodies; ++i) {
      const Mat3 root = matrix();
      made_.body_blocks.push_back(2.0 * Mat3::Identity() + root * root.transpose());
    }
    for (int i = 0; i < n_terms; ++i) made_.terms.push_back(term(i));
    made_.fixed.assign(n_rows_, 0);
    made_.b.resize(n_rows_, 3);
    made_.x.setZero(n_rows_, 3);
    for (Index row = 0; row < n_rows_; ++row) {
      made_.b.row(row) = vector().transpose();
      if (row % 37 != 5) continue;
      made_.fixed[row] = 1;
      made_.x.row(row) = vector().transpose();
    }
    made_.halo = matrix_halo(made_.matrix, *made_.layout);
  }

  RandomSystem take() { return std::move(made_); }

 private:
  // Returns a random number in [-1, 1). It is made from an integer of the generator, because the
  // integers are the same in all standard libraries. The numbers of std::uniform_real_distribution
  // are not.
  double number() { return 2.0 * static_cast<double>(random_() >> 8) / 16777216.0 - 1.0; }
  Vec3 vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  Mat3 matrix() {
    Mat3 m;
    for (int i = 0; i < 9; ++i) m(i % 3, i / 3) = number();
    return m;
  }

  // Adds unit masses, and a stiff anisotropic spring along every grid edge and one diagonal per
  // cell. The matrix stores only the rows of this rank.
  void springs() {
    std::vector<std::pair<Index, Index>> couplings;
    for (Index r = 0; r < side_; ++r)
      for (Index c = 0; c < side_; ++c) {
        const Index v = r * side_ + c;
        if (c + 1 < side_) couplings.push_back({v, v + 1});
        if (r + 1 < side_) couplings.push_back({v, v + side_});
        if (r + 1 < side_ && c + 1 < side_) couplings.push_back({v, v + side_ + 1});
      }
    const Index begin = std::min(made_.layout->begin(), n_cloth_);
    const Index end = std::min(made_.layout->end(), n_cloth_);
    BlockMatrix& a = made_.matrix = BlockMatrix(n_cloth_, couplings, begin, end);
    for (Index row = begin; row < end; ++row) a.block_map(a.diagonal()[row]) = Mat3::Identity();
    for (const auto& [i, j] : couplings) {
      const Mat3 root = matrix();
      const Mat3 stiffness = 4.0 * root * root.transpose();
      for (const auto& [row, other] : {std::pair(i, j), std::pair(j, i)}) {
        if (!made_.layout->owns(row)) continue;
        a.block_map(a.diagonal()[row]) += stiffness;
        a.block_map(a.find(row, other)) -= stiffness;
      }
    }
  }

  ExtraTerm term(int i) {
    ExtraTerm made;
    const Mat3 root = matrix();
    made.hessian = 10.0 * root * root.transpose();
    std::vector<Index> rows;
    while (rows.size() < 4) {
      const Index row = static_cast<Index>(random_() % n_cloth_);
      if (std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(row);
    }
    std::sort(rows.begin(), rows.end());
    const double weights[4] = {0.25, 0.75, -0.5, -0.5};
    const bool with_body = i % 3 == 0 && n_rows_ > n_cloth_;
    for (int e = 0; e < (with_body ? 2 : 4); ++e) add(made, rows[e], false, weights[e]);
    if (!with_body) return made;
    const Index body = static_cast<Index>(random_() % ((n_rows_ - n_cloth_) / 2));
    add(made, n_cloth_ + 2 * body, false, -1.0);
    add(made, n_cloth_ + 2 * body + 1, true, -1.0);
    return made;
  }

  void add(ExtraTerm& term, Index row, bool rotation, double weight) {
    term.entries[term.n_entries++] = {row, rotation, weight,
                                      rotation ? vector() : Vec3(Vec3::Zero())};
  }

  std::mt19937 random_{7};
  Index side_, n_cloth_, n_rows_;
  RandomSystem made_;
};

inline RandomSystem random_system(
    Index side, int n_bodies, int n_terms,
    std::shared_ptr<const Communicator> communicator = single_communicator()) {
  return RandomSystemBuilder(side, n_bodies, n_terms, std::move(communicator)).take();
}

// Assembles the whole system as a dense matrix, with three rows and columns for each system row.
inline Eigen::MatrixXd dense_matrix(const LinearSystem& system) {
  const Index rows = system.layout->n_rows(), n_cloth = system.matrix->n_rows();
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * rows, 3 * rows);
  for (Index row = 0; row < n_cloth; ++row)
    for (Index k = system.matrix->row_start()[row]; k < system.matrix->row_start()[row + 1]; ++k)
      dense.block<3, 3>(3 * row, 3 * system.matrix->columns()[k]) = system.matrix->block_map(k);
  for (Index row = n_cloth; row < rows; ++row)
    dense.block<3, 3>(3 * row, 3 * row) = (*system.body_blocks)[row - n_cloth];
  for (const ExtraTerm& term : *system.terms) {
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, 3 * rows);
    for (int e = 0; e < term.n_entries; ++e)
      jacobian.block<3, 3>(0, 3 * term.entries[e].row) += term.entries[e].jacobian();
    dense += system.term_scale * jacobian.transpose() * term.hessian * jacobian;
  }
  return dense;
}

// Multiplies the stiffness of the grid by `factor`. Masses, bodies and terms are unchanged.
inline void stiffen(RandomSystem& system, double factor) {
  BlockMatrix& a = system.matrix;
  for (Index row = 0; row < a.n_rows(); ++row)
    for (Index k = a.row_start()[row]; k < a.row_start()[row + 1]; ++k) {
      const Mat3 mass = (k == a.diagonal()[row] ? 1.0 : 0.0) * Mat3::Identity();
      a.block_map(k) = mass + factor * (a.block_map(k) - mass);
    }
}

}  // namespace loomstone::testing

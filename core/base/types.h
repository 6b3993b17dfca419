// Basic types: indices, vectors, small matrices, and row-major arrays that numpy can view without a
// copy. All quantities are in SI units.
#pragma once

#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace loomstone {

using Index = std::int32_t;

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;
using Mat32 = Eigen::Matrix<double, 3, 2>;
using Vector = Eigen::VectorXd;

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;   // (n x 3)
using Points2 = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;  // (n x 2)
using Triangles =
    Eigen::Matrix<Index, Eigen::Dynamic, 3, Eigen::RowMajor>;            // (m x 3) vertex indices
using Edges = Eigen::Matrix<Index, Eigen::Dynamic, 2, Eigen::RowMajor>;  // (k x 2) vertex indices

using PointsRef = Eigen::Ref<Points>;
using ConstPointsRef = Eigen::Ref<const Points>;

}  // namespace loomstone

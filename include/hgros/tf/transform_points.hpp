#pragma once

#include <Eigen/Core>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros {

/// Transforms points from the source frame into the target frame, in place. `points` is 3 x n, one point per column, in
/// meters. For a single point or pose, write `T * point` or `T * pose`.
template <class Derived>
void TransformPoints(const RigidTransform& T_target_source, Eigen::MatrixBase<Derived>& points) {
  using Scalar = typename Derived::Scalar;
  static_assert(Derived::RowsAtCompileTime == 3, "Points are columns of three numbers.");
  const Eigen::Matrix<Scalar, 3, 3> turn = T_target_source.rotation.toRotationMatrix().template cast<Scalar>();
  const Eigen::Matrix<Scalar, 3, 1> shift = T_target_source.translation.template cast<Scalar>();
  // Column by column: no temporary of the points' size.
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Matrix<Scalar, 3, 1> point = points.col(i);
    points.col(i) = turn * point + shift;
  }
}

/// The same as a copy.
template <class Derived>
[[nodiscard]] auto TransformedPoints(const RigidTransform& T_target_source, const Eigen::MatrixBase<Derived>& points) {
  typename Derived::PlainObject copy = points;
  TransformPoints(T_target_source, copy);
  return copy;
}

}  // namespace hgros

#pragma once

#include <array>
#include <cstdint>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::tf {

/// A RigidTransform as the seven numbers that samples store: a unit quaternion and a position.
struct Pose {
  double w = 1, x = 0, y = 0, z = 0;
  double px = 0, py = 0, pz = 0;
};

inline Pose PoseOf(const RigidTransform& T) {
  return {T.rotation.w(),    T.rotation.x(),    T.rotation.y(),   T.rotation.z(),
          T.translation.x(), T.translation.y(), T.translation.z()};
}

inline RigidTransform TransformOf(const Pose& p) {
  return {RigidTransform::Rotation(p.w, p.x, p.y, p.z), Eigen::Vector3d(p.px, p.py, p.pz)};
}

struct Position {
  double x, y, z;
};

/// The rotation of `a` applied to a position; `a` has unit length.
inline Position Rotated(const Pose& a, double px, double py, double pz) {
  // v + 2 w (u x v) + 2 u x (u x v)
  const double cx = 2 * (a.y * pz - a.z * py);
  const double cy = 2 * (a.z * px - a.x * pz);
  const double cz = 2 * (a.x * py - a.y * px);
  return {px + a.w * cx + (a.y * cz - a.z * cy), py + a.w * cy + (a.z * cx - a.x * cz),
          pz + a.w * cz + (a.x * cy - a.y * cx)};
}

/// T_a_b * T_b_c.
inline Pose operator*(const Pose& a, const Pose& b) {
  const Position p = Rotated(a, b.px, b.py, b.pz);
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
          a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z,
          a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x,
          p.x + a.px,
          p.y + a.py,
          p.z + a.pz};
}

inline Pose Inverse(const Pose& a) {
  const Pose back{a.w, -a.x, -a.y, -a.z, 0, 0, 0};
  const Position p = Rotated(back, a.px, a.py, a.pz);
  return {back.w, back.x, back.y, back.z, -p.x, -p.y, -p.z};
}

/// Between `a` (at fraction 0) and `b` (at 1): the position linearly, the rotation by slerp along the shorter way.
[[nodiscard]] Pose Interpolated(const Pose& a, const Pose& b, double fraction);

}  // namespace hgros::tf

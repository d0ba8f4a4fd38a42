#pragma once

#include <cstddef>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::tf {

/// Two numbers that the processor handles at once.
using Pair = double __attribute__((vector_size(16)));

/// A rigid transform as seven numbers: a unit quaternion and a position. Copied number by number, because the
/// processor waits if memory is stored in one width and read in another.
template <class Number>
struct PoseOf7 {
  Number w, x, y, z, px, py, pz;

  PoseOf7() = default;
  PoseOf7(Number qw, Number qx, Number qy, Number qz, Number tx, Number ty, Number tz)
      : w(qw), x(qx), y(qy), z(qz), px(tx), py(ty), pz(tz) {}
  PoseOf7(const PoseOf7& other)  // NOLINT(modernize-use-equals-default)
      : w(other.w), x(other.x), y(other.y), z(other.z), px(other.px), py(other.py), pz(other.pz) {}
  PoseOf7& operator=(const PoseOf7& other) {  // NOLINT(bugprone-unhandled-self-assignment): harmless.
    w = other.w;
    x = other.x;
    y = other.y;
    z = other.z;
    px = other.px;
    py = other.py;
    pz = other.pz;
    return *this;
  }
  ~PoseOf7() = default;
};

using Pose = PoseOf7<double>;

inline Pose IdentityPose() { return {1, 0, 0, 0, 0, 0, 0}; }

inline Pose PoseOf(const RigidTransform& T) {
  return {T.rotation.w(),    T.rotation.x(),    T.rotation.y(),   T.rotation.z(),
          T.translation.x(), T.translation.y(), T.translation.z()};
}

inline RigidTransform TransformOf(const Pose& p) {
  return {RigidTransform::Rotation(p.w, p.x, p.y, p.z), Eigen::Vector3d(p.px, p.py, p.pz)};
}

/// T_a_b * T_b_c.
template <class Number>
inline PoseOf7<Number> operator*(const PoseOf7<Number>& a, const PoseOf7<Number>& b) {
  // The rotated position is v + w c + u x c with c = 2 (u x v).
  const Number half_x = a.y * b.pz - a.z * b.py;
  const Number half_y = a.z * b.px - a.x * b.pz;
  const Number half_z = a.x * b.py - a.y * b.px;
  const Number cx = half_x + half_x;
  const Number cy = half_y + half_y;
  const Number cz = half_z + half_z;
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z,      a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x,
          (b.px + a.px) + (a.w * cx + (a.y * cz - a.z * cy)), (b.py + a.py) + (a.w * cy + (a.z * cx - a.x * cz)),
          (b.pz + a.pz) + (a.w * cz + (a.x * cy - a.y * cx))};
}

inline Pose Inverse(const Pose& a) {
  const Pose moved = Pose(a.w, -a.x, -a.y, -a.z, 0, 0, 0) * Pose(1, 0, 0, 0, a.px, a.py, a.pz);
  return {a.w, -a.x, -a.y, -a.z, -moved.px, -moved.py, -moved.pz};
}

/// The product of `count` poses (at least one). Both halves are multiplied in parallel.
inline Pose Product(const Pose* poses, std::size_t count) {
  if (count == 1) return poses[0];
  const auto pair = [](const Pose& a, const Pose& b) {
    return PoseOf7<Pair>(Pair{a.w, b.w}, Pair{a.x, b.x}, Pair{a.y, b.y}, Pair{a.z, b.z}, Pair{a.px, b.px},
                         Pair{a.py, b.py}, Pair{a.pz, b.pz});
  };
  const std::size_t half = (count + 1) / 2;
  PoseOf7<Pair> both = pair(poses[0], poses[half]);
  std::size_t i = 1;
  for (; half + i < count; ++i) both = both * pair(poses[i], poses[half + i]);
  const Pose second(both.w[1], both.x[1], both.y[1], both.z[1], both.px[1], both.py[1], both.pz[1]);
  Pose first(both.w[0], both.x[0], both.y[0], both.z[0], both.px[0], both.py[0], both.pz[0]);
  if (i < half) first = first * poses[i];
  return first * second;
}

}  // namespace hgros::tf

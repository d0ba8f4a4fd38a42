#pragma once

#include <Eigen/Geometry>

namespace hgros {

/// A rotation, then a translation: p_target = rotation * p_source + translation for a T_target_source; also the pose of
/// the source frame in the target frame. In meters.
struct RigidTransform {
  /// Converts from and to Eigen::Quaterniond. Its alignment does not depend on what a program is compiled for.
  using Rotation = Eigen::Quaternion<double, Eigen::DontAlign>;

  Rotation rotation = Rotation::Identity();  ///< Unit length.
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  /// The identity.
  RigidTransform() = default;
  RigidTransform(const Rotation& turn, const Eigen::Vector3d& shift) : rotation(turn), translation(shift) {}
  explicit RigidTransform(const Eigen::Isometry3d& isometry)
      : rotation(isometry.linear()), translation(isometry.translation()) {}
  /// A rotation about z by `yaw`, then about the new y by `pitch`, then about the new x by `roll`. In radians.
  [[nodiscard]] static RigidTransform FromYawPitchRoll(const Eigen::Vector3d& shift, double yaw, double pitch,
                                                       double roll) {
    using Eigen::AngleAxisd;
    using Eigen::Vector3d;
    return {Rotation(AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
                     AngleAxisd(roll, Vector3d::UnitX())),
            shift};
  }

  [[nodiscard]] RigidTransform Inverse() const {
    const Rotation back = rotation.conjugate();
    return {back, -(back * translation)};
  }
  [[nodiscard]] Eigen::Isometry3d Isometry() const {
    Eigen::Isometry3d isometry = Eigen::Isometry3d::Identity();
    isometry.linear() = rotation.toRotationMatrix();
    isometry.translation() = translation;
    return isometry;
  }

  /// T_a_b * T_b_c is T_a_c.
  friend RigidTransform operator*(const RigidTransform& a, const RigidTransform& b) {
    return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
  }
  /// A point of the source frame in the target frame.
  friend Eigen::Vector3d operator*(const RigidTransform& T_target_source, const Eigen::Vector3d& point) {
    return T_target_source.rotation * point + T_target_source.translation;
  }
};

}  // namespace hgros

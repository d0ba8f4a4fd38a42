#pragma once

#include <gtest/gtest.h>

#include <random>

#include "hgros/tf/rigid_transform.hpp"

namespace hgros::test {

inline RigidTransform Shift(double x, double y = 0, double z = 0) {
  return {RigidTransform::Rotation::Identity(), Eigen::Vector3d(x, y, z)};
}

inline RigidTransform TurnZ(double radians) {
  return {RigidTransform::Rotation(Eigen::AngleAxisd(radians, Eigen::Vector3d::UnitZ())), Eigen::Vector3d::Zero()};
}

inline RigidTransform RandomTransform(std::mt19937_64& random, double reach = 3) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> along(-reach, reach);
  RigidTransform::Rotation rotation(normal(random), normal(random), normal(random), normal(random));
  rotation.normalize();
  const double x = along(random);
  const double y = along(random);
  return {rotation, Eigen::Vector3d(x, y, along(random))};
}

/// The larger of the distance and the angle (as a chord) between two transforms.
inline double Difference(const RigidTransform& a, const RigidTransform& b) {
  const double same = (a.rotation.coeffs() - b.rotation.coeffs()).norm();
  const double opposite = (a.rotation.coeffs() + b.rotation.coeffs()).norm();
  return std::max((a.translation - b.translation).norm(), std::min(same, opposite));
}

}  // namespace hgros::test

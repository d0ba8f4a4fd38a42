#pragma once

#include <cmath>

#include "tf/tree/pose.hpp"

namespace hgros::tf {
namespace slerp {

// sin(t x) / sin(x) = t (1 + b1 (1 + b2 (1 + ...))) with b_i = (t^2 / (i (2 i + 1)) - i / (2 i + 1)) (cos(x) - 1):
// D. Eberly, "A Fast and Accurate Algorithm for Computing SLERP", 2011. Each b_i is below (1 - cos(x)) / 2, so Terms of
// them leave a relative error of the Terms-th power of that. Both weights at once.
template <int Terms>
inline Pair SeriesWeights(double cosine_minus_one, Pair fractions) {
  const Pair squares = fractions * fractions;
  Pair sum = {1, 1};
#pragma GCC unroll 16
  for (int i = Terms; i >= 1; --i) {
    sum = 1 + (squares * (1.0 / (i * (2.0 * i + 1))) - i / (2.0 * i + 1)) * cosine_minus_one * sum;
  }
  return fractions * sum;
}

inline Pair Weights(double cosine, Pair fractions) {
  const double cosine_minus_one = cosine - 1;
  if (cosine_minus_one > -1e-5) return SeriesWeights<3>(cosine_minus_one, fractions);
  if (cosine_minus_one > -2e-3) return SeriesWeights<5>(cosine_minus_one, fractions);
  if (cosine_minus_one > -0.1) return SeriesWeights<12>(cosine_minus_one, fractions);
  const double angle = std::acos(cosine);
  const double sine = std::sin(angle);
  return Pair{std::sin(fractions[0] * angle) / sine, std::sin(fractions[1] * angle) / sine};
}

}  // namespace slerp

/// Between `a` (at fraction 0) and `b` (at 1): the position linearly, the rotation by slerp along the shorter way.
inline Pose Interpolated(const Pose& a, const Pose& b, double fraction) {
  const double dot = (a.w * b.w + a.x * b.x) + (a.y * b.y + a.z * b.z);
  const Pair weights = slerp::Weights(std::abs(dot), Pair{1 - fraction, fraction});
  const double of_a = weights[0];
  const double of_b = std::copysign(weights[1], dot);
  return {of_a * a.w + of_b * b.w,        of_a * a.x + of_b * b.x,         of_a * a.y + of_b * b.y,
          of_a * a.z + of_b * b.z,        a.px + fraction * (b.px - a.px), a.py + fraction * (b.py - a.py),
          a.pz + fraction * (b.pz - a.pz)};
}

}  // namespace hgros::tf

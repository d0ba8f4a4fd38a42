#include "tf/pose.hpp"

#include <cmath>

namespace hgros::tf {
namespace {

struct Weights {
  double a, b;
};

// sin(t x) / sin(x) = t (1 + b1 (1 + b2 (1 + ...))) with b_i = (t^2 / (i (2 i + 1)) - i / (2 i + 1)) (cos(x) - 1):
// D. Eberly, "A Fast and Accurate Algorithm for Computing SLERP", 2011. Each b_i is below (1 - cos(x)) / 2, so Terms of
// them leave a relative error of the Terms-th power of that.
template <int Terms>
Weights SeriesWeights(double cosine_minus_one, double fraction) {
  const double rest = 1 - fraction;
  const double rest_square = rest * rest;
  const double fraction_square = fraction * fraction;
  double a = 1;
  double b = 1;
#pragma GCC unroll 16
  for (int i = Terms; i >= 1; --i) {
    const double u = cosine_minus_one * (1.0 / (i * (2.0 * i + 1)));
    const double v = cosine_minus_one * (i / (2.0 * i + 1));
    a = 1 + (u * rest_square - v) * a;
    b = 1 + (u * fraction_square - v) * b;
  }
  return {rest * a, fraction * b};
}

Weights SlerpWeights(double cosine, double fraction) {
  const double cosine_minus_one = cosine - 1;
  if (cosine_minus_one > -1e-5) return SeriesWeights<3>(cosine_minus_one, fraction);
  if (cosine_minus_one > -2e-3) return SeriesWeights<5>(cosine_minus_one, fraction);
  if (cosine_minus_one > -0.1) return SeriesWeights<12>(cosine_minus_one, fraction);
  const double angle = std::acos(cosine);
  const double sine = std::sin(angle);
  return {std::sin((1 - fraction) * angle) / sine, std::sin(fraction * angle) / sine};
}

}  // namespace

Pose Interpolated(const Pose& a, const Pose& b, double fraction) {
  const double dot = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
  const Weights weights = SlerpWeights(std::abs(dot), fraction);
  const double of_a = weights.a;
  const double of_b = std::copysign(weights.b, dot);
  return {of_a * a.w + of_b * b.w,        of_a * a.x + of_b * b.x,         of_a * a.y + of_b * b.y,
          of_a * a.z + of_b * b.z,        a.px + fraction * (b.px - a.px), a.py + fraction * (b.py - a.py),
          a.pz + fraction * (b.pz - a.pz)};
}

}  // namespace hgros::tf

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace hgros::bench {

/// One implementation of a transform tree, holding one chain. All times are stamps in ns.
class Side {
 public:
  Side() = default;
  Side(const Side&) = delete;
  Side& operator=(const Side&) = delete;
  virtual ~Side() = default;

  /// Sets every edge at step `step`, in order.
  virtual void SetAll(int step) = 0;
  /// Sets one edge `count` times, the next edge each time, from step `first` on.
  virtual void SetMany(int first, int count) = 0;
  /// Leaf to root, latest. The returned number keeps the compiler from removing the call.
  virtual double Latest() = 0;
  /// 0 if it is too old or too new.
  virtual double At(std::int64_t stamp) = 0;
};

/// By ids.
std::unique_ptr<Side> MakeOurs();
/// By names.
std::unique_ptr<Side> MakeOursNamed();
/// Null where tf2 is not installed.
std::unique_ptr<Side> MakeTf2();

/// Points per second, float x y z intensity, in place.
double CloudPointsPerSecond(int points, int rounds);

}  // namespace hgros::bench

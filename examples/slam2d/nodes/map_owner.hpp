#pragma once

#include <cstdint>

#include "../app/messages.hpp"
#include "../laser_scan.hpp"
#include "../mapper.hpp"

namespace slam2d {

/// The core's Mapper, with a state that another owner can continue from, bit for bit.
///
/// Threading: one thread at a time.
class MapOwner {
 public:
  explicit MapOwner(const MapOptions& options) : mapper_(options) {}

  /// See Mapper::SetOptions.
  void SetOptions(const MapOptions& options) { mapper_.SetOptions(options); }

  /// See Mapper::Add.
  MapDelta Add(const LaserScan2& scan, const ScanMatch& match);

  /// The sequence of the next expected scan.
  [[nodiscard]] std::uint64_t next_scan() const { return next_scan_; }
  [[nodiscard]] const OccupancyMap& map() const { return mapper_.map(); }

  void Save(msg::MapState& state) const;
  /// Continues with the state's map and this owner's options.
  ///
  /// Errors: throws std::invalid_argument if the state is inconsistent or its cells differ from the options.
  void Restore(const msg::MapState& state);

 private:
  Mapper mapper_;
  std::uint64_t next_scan_ = 0;
};

}  // namespace slam2d

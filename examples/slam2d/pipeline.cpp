#include "pipeline.hpp"

#include <bit>

namespace slam2d {
namespace {

class Fnv1a {
 public:
  void Byte(std::uint8_t byte) { hash_ = (hash_ ^ byte) * 0x100000001b3U; }
  // Least significant byte first on every machine.
  void Word(std::uint64_t word) {
    for (unsigned shift = 0; shift < 64; shift += 8) Byte(static_cast<std::uint8_t>(word >> shift));
  }
  void Number(double number) { Word(std::bit_cast<std::uint64_t>(number)); }
  [[nodiscard]] std::uint64_t hash() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

}  // namespace

std::uint64_t HashMap(const OccupancyMap& map) {
  Fnv1a hash;
  hash.Word(map.version());
  for (const auto& [index, tile] : map.tiles()) {
    hash.Word(static_cast<std::uint64_t>(index.x));
    hash.Word(static_cast<std::uint64_t>(index.y));
    for (const std::int8_t value : tile) hash.Byte(static_cast<std::uint8_t>(value));
  }
  return hash.hash();
}

std::uint64_t HashTrajectory(std::span<const ScanMatch> trajectory) {
  Fnv1a hash;
  for (const ScanMatch& match : trajectory) {
    hash.Word(match.sequence);
    hash.Number(match.stamp_seconds);
    hash.Number(match.T_map_laser.x);
    hash.Number(match.T_map_laser.y);
    hash.Number(match.T_map_laser.theta);
  }
  return hash.hash();
}

const ScanMatch& Pipeline::Add(const LaserScan2& scan) {
  trajectory_.push_back(matcher_.Match(scan));
  matcher_.Apply(mapper_.Add(scan, trajectory_.back()));
  return trajectory_.back();
}

}  // namespace slam2d

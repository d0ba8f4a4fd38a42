#include "tunables.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <set>
#include <string>
#include <type_traits>

#include "pipeline.hpp"
#include "simulated_building.hpp"

namespace slam2d {
namespace {

// Number of bytes of an Options that belong to no tunable number.
template <class Options>
std::ptrdiff_t BytesLeftOut() {
  Options options;
  std::memset(static_cast<void*>(&options), 0xff, sizeof options);
  ForEachTunable("all", options, [](const std::string&, const auto&, auto& value) {
    std::memset(static_cast<void*>(&value), 0, sizeof value);
  });
  unsigned char bytes[sizeof options];
  std::memcpy(bytes, &options, sizeof options);
  return std::count(std::begin(bytes), std::end(bytes), 0xff);
}

TEST(Tunables, IncludeEveryNumber) {
  EXPECT_EQ(BytesLeftOut<MapOptions>(), 0);
  EXPECT_EQ(BytesLeftOut<RevisitOptions>(), 4);      // padding behind an int
  EXPECT_EQ(BytesLeftOut<MatcherOptions>(), 4 + 4);  // the same, and that of RevisitOptions
}

TEST(Tunables, HaveDefaultsWithinTheirBoundsAndOnePathEach) {
  std::set<std::string> paths;
  const auto check = [&paths](const std::string& path, const auto& tunable, const auto& value) {
    EXPECT_TRUE(paths.insert(path).second) << path;
    EXPECT_LE(tunable.least, static_cast<double>(value)) << path;
    EXPECT_GE(tunable.most, static_cast<double>(value)) << path;
    EXPECT_NE(std::string(tunable.description), "") << path;
  };
  MapOptions map;
  MatcherOptions matcher;
  ForEachTunable("slam.map", map, check);
  ForEachTunable("slam.matcher", matcher, check);
  EXPECT_TRUE(paths.contains("slam.map.cell_size_m"));
  EXPECT_TRUE(paths.contains("slam.matcher.revisit.lag_m"));
}

// Scans are matched and drawn with one number at the end of its bounds. Matcher and mapper must stay consistent.
template <class Options, class Run>
void TryAllBounds(const Run& run) {
  Options defaults;
  ForEachTunable("all", defaults, [&](const std::string& path, const auto& tunable, const auto&) {
    for (const double bound : {tunable.least, tunable.most}) {
      Options options;
      ForEachTunable("all", options, [&](const std::string& other, const auto&, auto& value) {
        if (other == path) value = static_cast<std::remove_reference_t<decltype(value)>>(bound);
      });
      run(path + " = " + std::to_string(bound), options);
    }
  });
}

void Follow(const std::string& what, const MatcherOptions& matcher, const MapOptions& map) {
  SCOPED_TRACE(what);
  SimulatedBuilding building({.scans = 12, .beams = 45});
  Pipeline pipeline(matcher, map);
  LaserScan2 scan;
  while (building.Next(scan)) pipeline.Add(scan);
  EXPECT_EQ(HashMap(pipeline.matcher().replica()), HashMap(pipeline.map()));
  for (const ScanMatch& match : pipeline.trajectory()) {
    EXPECT_TRUE(std::isfinite(match.T_map_laser.x) && std::isfinite(match.T_map_laser.theta)) << match.sequence;
  }
}

TEST(Tunables, WorkAtTheEndsOfTheirBounds) {
  TryAllBounds<MapOptions>([](const std::string& what, const MapOptions& map) { Follow(what, {}, map); });
  TryAllBounds<MatcherOptions>([](const std::string& what, const MatcherOptions& matcher) {
    Follow(what, matcher, {});
    MatcherOptions early = matcher;  // so that it searches for old places within the few scans
    early.revisit.lag_m = 0.1;
    Follow(what + ", early", early, {});
  });
}

}  // namespace
}  // namespace slam2d

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tracing/traced.hpp"

namespace hgros::cli {

/// Durations in ns, each exact.
class Durations {
 public:
  void Add(std::int64_t ns) { all_.push_back(ns); }
  /// The value that the share `q` (0 to 1) does not exceed; 0 without values.
  [[nodiscard]] std::int64_t Quantile(double q) const;
  [[nodiscard]] double Mean() const;

 private:
  std::vector<std::int64_t> all_;
};

/// One message of a way: published, encoded, transported, waiting for its node, handled until the next one is
/// published.
struct Hop {
  std::string channel;
  std::size_t publisher = 0;  ///< Index in Traced::sessions, as the next one.
  std::size_t session = 0;
  std::string node;
  Durations encode;
  Durations transport;
  Durations wait;
  Durations run;  ///< Of the last hop: the whole callback, which is no part of the way.
  Durations all;
  double share = 0;       ///< Of the whole way, by the means.
  bool critical = false;  ///< It takes the longest.
};

/// One way by which messages have come from one channel to a node of another.
struct Path {
  std::vector<Hop> hops;
  Durations all;  ///< From the first publish to the beginning of the last callback.
  std::size_t messages = 0;
};

struct Paths {
  std::vector<Path> paths;                     ///< The most used first.
  std::size_t arrived = 0;                     ///< Messages that nodes of the last channel have handled.
  std::size_t interrupted = 0;                 ///< Of these, those whose way could not be seen as a whole.
  std::size_t lost = 0;                        ///< Those that were too many to follow.
  std::map<std::string, std::size_t> origins;  ///< The channels where the ways of the others began.
};

/// The ways from one channel to another, as the causes of the messages tell them.
[[nodiscard]] Paths PathsBetween(const Traced& traced, std::string_view from, std::string_view to);

}  // namespace hgros::cli

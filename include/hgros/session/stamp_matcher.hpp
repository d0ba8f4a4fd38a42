#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/clock/time.hpp"

namespace hgros {

struct MatchOptions {
  Duration tolerance{0};   ///< The longest time between the first and the last stamp of a set. 0: stamps are equal.
  std::size_t depth = 16;  ///< Number of items of a channel that wait at most.
};

/// What has become of the items of one channel. The rest waits.
struct MatchCounts {
  std::uint64_t matched = 0;
  std::uint64_t unmatched = 0;   ///< Dropped: no set can have it, because another channel went past it.
  std::uint64_t overflowed = 0;  ///< Dropped: `depth` newer ones waited for another channel.
  std::uint64_t late = 0;        ///< Dropped: its stamp was at most a second before that of the item before it.
};

/// Matches items of two to nine channels by their stamps. A set has one item of each channel. docs/synchronizing.md
/// explains the algorithm and how to choose the tolerance. As long as the stamps of each channel do not go back, and no
/// channel overflows:
///
///   1. The stamps of a set are at most `tolerance` apart.
///   2. An item is in one set at most, and the items of each channel are in the order of the sets.
///   3. No other way to form sets with 1 and 2 gives more of them.
///   4. A set is complete with the Push() of its last item: nothing is held back to wait for a better match.
///   5. The sets depend on the stamps alone, not on the order in which items of different channels come.
///
/// A stamp more than a second before the one before it on the channel begins a new time, as when a recording is played
/// again: all that waits is dropped and counted as unmatched.
///
/// Thread safety: none.
template <class Item>
class StampMatcher {
 public:
  struct Stamped {
    Time stamp;
    Item item;
  };
  /// In the order of the channels.
  using Set = std::vector<Stamped>;

  /// Errors: throws Error if the options or the number of channels cannot be used.
  StampMatcher(std::size_t channels, MatchOptions options) : options_(options), channels_(channels) {
    if (channels < 2 || channels > 9) throw Error("Messages of two to nine channels are matched.");
    if (options.tolerance < Duration(0)) throw Error("The tolerance of a match is below zero.");
    if (options.depth == 0) throw Error("No message may wait for a match.", {}, "Set depth to 1 or more.");
  }

  /// Adds an item of a channel, which counts from 0. Returns the set that is complete with it, if there is one.
  std::optional<Set> Push(std::size_t channel, Time stamp, Item item) {
    Channel& own = channels_.at(channel);
    if (stamp < own.newest) {
      if (own.newest <= Later(stamp, kLatest)) {
        ++own.counts.late;
        return std::nullopt;
      }
      BeginNewTime();
    }
    own.newest = stamp;
    own.waiting.push_back({stamp, std::move(item)});
    if (own.waiting.size() > options_.depth) {
      own.waiting.pop_front();
      ++own.counts.overflowed;
    }
    return NextSet();
  }

  [[nodiscard]] const MatchCounts& counts(std::size_t channel) const { return channels_.at(channel).counts; }

 private:
  static constexpr Duration kLatest = std::chrono::seconds(1);
  static constexpr Time kBegin{std::numeric_limits<std::int64_t>::min()};

  struct Channel {
    Time newest = kBegin;
    std::deque<Stamped> waiting;
    MatchCounts counts;
  };

  // The first item of the channel that is the most behind is in the next set, or in none: what comes later on the other
  // channels is even farther from it. Before each Push() some channel is empty, and it is again after one set.
  std::optional<Set> NextSet() {
    const auto is_empty = [](const Channel& one) { return one.waiting.empty(); };
    const auto first_stamp = [](const Channel& one) { return one.waiting.front().stamp; };
    while (std::ranges::none_of(channels_, is_empty)) {
      const auto [behind, ahead] = std::ranges::minmax_element(channels_, {}, first_stamp);
      if (first_stamp(*ahead) <= Later(first_stamp(*behind), options_.tolerance)) {
        Set set;
        for (Channel& one : channels_) {
          set.push_back(std::move(one.waiting.front()));
          one.waiting.pop_front();
          ++one.counts.matched;
        }
        return set;
      }
      behind->waiting.pop_front();
      ++behind->counts.unmatched;
    }
    return std::nullopt;
  }

  void BeginNewTime() {
    for (Channel& one : channels_) {
      one.counts.unmatched += one.waiting.size();
      one.waiting.clear();
      one.newest = kBegin;
    }
  }

  MatchOptions options_;
  std::vector<Channel> channels_;
};

}  // namespace hgros

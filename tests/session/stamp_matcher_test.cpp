#include "hgros/session/stamp_matcher.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "support/seed.hpp"

namespace hgros::stamp_matcher_test {
namespace {

using namespace std::chrono_literals;

using Matcher = StampMatcher<char>;
using Stamps = std::vector<std::int64_t>;  // Of one channel.

MatchOptions Within(std::int64_t tolerance, std::size_t depth = 16) { return {Duration(tolerance), depth}; }

// The items, or nothing.
std::string Pushed(Matcher& matcher, std::size_t channel, std::int64_t stamp, char item) {
  std::string items;
  if (const auto set = matcher.Push(channel, {stamp}, item)) {
    for (const Matcher::Stamped& one : *set) items += one.item;
  }
  return items;
}

TEST(StampMatcher, MatchesEqualStampsAndDropsOthers) {
  Matcher matcher(3, Within(0));
  EXPECT_EQ(Pushed(matcher, 0, 10, 'a'), "");
  EXPECT_EQ(Pushed(matcher, 0, 20, 'b'), "");
  EXPECT_EQ(Pushed(matcher, 2, 20, 'd'), "");
  EXPECT_EQ(Pushed(matcher, 1, 20, 'c'), "bcd");
  EXPECT_EQ(matcher.counts(0).matched, 1U);
  EXPECT_EQ(matcher.counts(0).unmatched, 1U);
  EXPECT_EQ(matcher.counts(1).unmatched, 0U);
}

TEST(StampMatcher, DropsTheOldestWhenAChannelIsSilent) {
  Matcher matcher(2, Within(1, 2));
  for (const char item : {'a', 'b', 'c'}) EXPECT_EQ(Pushed(matcher, 0, item, item), "");
  EXPECT_EQ(matcher.counts(0).overflowed, 1U);
  EXPECT_EQ(Pushed(matcher, 1, 'a', 'x'), "bx") << "within the tolerance";
  EXPECT_EQ(Pushed(matcher, 1, 'b', 'y'), "cy");
}

TEST(StampMatcher, DropsLateItemsAndBeginsAgainWhenTimeGoesBack) {
  const std::int64_t second = Duration(1s).count();
  Matcher matcher(2, Within(0));
  (void)Pushed(matcher, 0, 5 * second, 'a');
  EXPECT_EQ(Pushed(matcher, 0, 4 * second, 'b'), "");
  EXPECT_EQ(matcher.counts(0).late, 1U);
  (void)Pushed(matcher, 0, second, 'c');
  EXPECT_EQ(matcher.counts(0).unmatched, 1U) << "a has waited";
  EXPECT_EQ(Pushed(matcher, 1, second, 'd'), "cd");
}

TEST(StampMatcher, RefusesWhatItCannotMatch) {
  for (const std::size_t channels : {1U, 10U}) EXPECT_THROW(Matcher(channels, Within(0)), Error);
  EXPECT_THROW(Matcher(2, Within(-1)), Error);
  EXPECT_THROW(Matcher(2, Within(0, 0)), Error);
}

// Tries everything: the most sets that the items from `begin` on can form.
class Oracle {
 public:
  Oracle(const std::vector<Stamps>& channels, std::int64_t tolerance) : channels_(channels), tolerance_(tolerance) {}

  int Most(const std::vector<std::size_t>& begin) {
    const auto known = most_.find(begin);
    if (known != most_.end()) return known->second;
    int most = 0;
    Stamps heads;
    for (std::size_t i = 0; i < channels_.size(); ++i) {
      if (begin[i] == channels_[i].size()) return most_[begin] = 0;
      heads.push_back(channels_[i][begin[i]]);
      std::vector<std::size_t> skipped = begin;
      ++skipped[i];
      most = std::max(most, Most(skipped));
    }
    const auto [first, last] = std::ranges::minmax(heads);
    if (last - first <= tolerance_) {
      std::vector<std::size_t> used = begin;
      for (std::size_t& one : used) ++one;
      most = std::max(most, 1 + Most(used));
    }
    return most_[begin] = most;
  }

 private:
  const std::vector<Stamps>& channels_;
  const std::int64_t tolerance_;
  std::map<std::vector<std::size_t>, int> most_;
};

// The stamps of the sets, if the items of the channels come in a random order.
std::vector<Stamps> SetsOf(const std::vector<Stamps>& channels, std::int64_t tolerance, std::mt19937_64& random) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < channels.size(); ++i) order.insert(order.end(), channels[i].size(), i);
  std::ranges::shuffle(order, random);
  Matcher matcher(channels.size(), Within(tolerance));
  std::vector<std::size_t> next(channels.size());
  std::vector<Stamps> sets;
  for (const std::size_t i : order) {
    const auto set = matcher.Push(i, {channels[i][next[i]++]}, ' ');
    if (!set) continue;
    Stamps& stamps = sets.emplace_back();
    for (const Matcher::Stamped& one : *set) stamps.push_back(one.stamp.nanoseconds);
  }
  return sets;
}

TEST(StampMatcher, FormsTheMostSetsWhateverTheOrderOfTheChannels) {
  std::mt19937_64 random(test::Seed());
  const auto below = [&random](std::size_t end) { return static_cast<std::int64_t>(random() % end); };
  for (int round = 0; round < test::Rounds(300, 3000); ++round) {
    std::vector<Stamps> channels(2 + random() % 3);
    for (Stamps& stamps : channels) {
      stamps.resize(random() % 7);
      for (std::int64_t& stamp : stamps) stamp = below(30);
      std::ranges::sort(stamps);
    }
    const std::int64_t tolerance = below(12);
    const std::vector<Stamps> sets = SetsOf(channels, tolerance, random);
    EXPECT_EQ(SetsOf(channels, tolerance, random), sets);
    EXPECT_EQ(int(sets.size()), Oracle(channels, tolerance).Most(std::vector<std::size_t>(channels.size())));
    for (const Stamps& set : sets) {
      const auto [first, last] = std::ranges::minmax(set);
      EXPECT_LE(last - first, tolerance);
    }
  }
}

}  // namespace
}  // namespace hgros::stamp_matcher_test

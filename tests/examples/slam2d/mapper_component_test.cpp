#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include <hgros/testing/harness.hpp>

#include "app/channels.hpp"
#include "components/mapper.hpp"
#include "components/matcher.hpp"
#include "components/writer.hpp"
#include "pipeline.hpp"
#include "simulated_building.hpp"
#include "support/scratch_folder.hpp"

namespace slam2d {
namespace {

using MapperHarness = hgros::testing::Harness<MapperComponent>;
using MatcherHarness = hgros::testing::Harness<Matcher>;

// Passes on what `from` has sent since the last time.
template <class Message>
void Pass(auto& from, auto& to, std::string_view channel) {
  for (const auto& one : from.template Take<Message>(channel)) to.Feed(channel, one);
}

std::vector<msg::MatchedScan> MatchedScans(std::size_t count) {
  SimulatedBuilding building({.scans = count});
  Pipeline pipeline;
  std::vector<msg::MatchedScan> all;
  for (LaserScan2 scan; building.Next(scan);) {
    msg::MatchedScan& one = all.emplace_back();
    Write(scan, *one.mutable_scan());
    Write(pipeline.Add(scan), *one.mutable_match());
  }
  return all;
}

TEST(MapperComponent, GoesOnFromASavedStateBitForBit) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(60);
  MapperHarness whole;
  for (const msg::MatchedScan& one : scans) whole.Feed(kPreChannel, one);

  MapperHarness first;
  for (std::size_t i = 0; i < 25; ++i) first.Feed(kPreChannel, scans[i]);
  MapperHarness second({.state = first.Save()});
  for (std::size_t i = 25; i < scans.size(); ++i) second.Feed(kPreChannel, scans[i]);
  EXPECT_EQ(second->Save().SerializeAsString(), whole->Save().SerializeAsString());
  EXPECT_EQ(second.Take<msg::MapUpdate>(kNextChannel).size(), scans.size() - 25);
}

TEST(MapperComponent, TellsWithWhichMapItBegins) {
  MapperHarness empty;
  const auto begun = empty.Take<msg::MapState>(kMapState);
  ASSERT_EQ(begun.size(), 1U);
  EXPECT_EQ(begun.front()->next_scan(), 0U);
  empty.Feed(kPreChannel, MatchedScans(1).front());
  MapperHarness other({.state = empty.Save()});
  const auto went_on = other.Take<msg::MapState>(kMapState);
  ASSERT_EQ(went_on.size(), 1U);
  EXPECT_EQ(went_on.front()->SerializeAsString(), empty->Save().SerializeAsString());
}

TEST(MapperComponent, AnswersAScanThatIsSentAgainWithTheSameUpdate) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(2);
  MapperHarness mapper;
  for (const msg::MatchedScan& one : scans) mapper.Feed(kPreChannel, one);
  MapperHarness successor({.state = mapper.Save()});
  mapper.Feed(kPreChannel, scans.back());
  successor.Feed(kPreChannel, scans.back());
  const auto updates = mapper.Take<msg::MapUpdate>(kNextChannel);
  ASSERT_EQ(updates.size(), 3U);
  EXPECT_EQ(updates[1]->SerializeAsString(), updates[2]->SerializeAsString());
  const auto answer = successor.Take<msg::MapUpdate>(kNextChannel).front();
  EXPECT_TRUE(answer->whole());
  EXPECT_EQ(answer->version(), updates[1]->version());
  EXPECT_EQ(answer->match().SerializeAsString(), updates[1]->match().SerializeAsString());
  EXPECT_EQ(answer->cells_size(), mapper->Save().map().cells_size());
}

TEST(MapperComponent, DrawsOnAfterLostScansAndSaysSo) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(5);
  MapperHarness mapper;
  mapper.Feed(kPreChannel, scans[0]);
  mapper.Feed(kPreChannel, scans[4]);
  EXPECT_EQ(mapper.status().state, hgros::ComponentState::kRunning);
  ASSERT_EQ(mapper.lines().size(), 1U);
  EXPECT_NE(mapper.lines().front().find("The scans from 1 to 3 are not in this map."), std::string::npos);
}

TEST(MapperComponent, FailsWhenAnotherLogBegins) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(3);
  MapperHarness mapper;
  for (const msg::MatchedScan& one : scans) mapper.Feed(kPreChannel, one);
  mapper.Feed(kPreChannel, scans.front());
  EXPECT_EQ(mapper.status().state, hgros::ComponentState::kFailed);
}

TEST(MapperComponent, RefusesAStateWithCellsOfAnotherSize) {
  MapperHarness coarse({.params = "cell_size_m: 0.1"});
  EXPECT_THROW(MapperHarness({.state = coarse.Save()}), hgros::Error);
}

TEST(MatcherComponent, FollowsAMapperThatGoesOnWithAnOlderMap) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(12);
  MapperHarness mapper;
  MatcherHarness matcher;
  const auto go = [&](MapperHarness& with, std::size_t scan) {
    matcher.Feed(kScan, scans[scan].scan());
    Pass<msg::MatchedScan>(matcher, with, kPreChannel);
    Pass<msg::MapUpdate>(with, matcher, kNextChannel);
  };
  Pass<msg::MapState>(mapper, matcher, kMapState);
  for (std::size_t i = 0; i < 4; ++i) go(mapper, i);
  const auto checkpoint = mapper.Save();
  for (std::size_t i = 4; i < 8; ++i) go(mapper, i);

  MapperHarness successor({.state = checkpoint});
  Pass<msg::MapState>(successor, matcher, kMapState);
  for (std::size_t i = 8; i < scans.size(); ++i) go(successor, i);
  EXPECT_EQ(matcher.status().state, hgros::ComponentState::kRunning) << matcher.status().sentence;
  EXPECT_EQ(successor->Save().next_scan(), scans.size());
}

TEST(MatcherComponent, AMapperThatMovesMayTellOfItselfLate) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(60);
  std::optional<MapperHarness> mapper(std::in_place);
  MatcherHarness matcher;
  Pass<msg::MapState>(*mapper, matcher, kMapState);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (i % 20 == 10) mapper.emplace(hgros::testing::HarnessOptions{.state = mapper->Save()});
    matcher.Feed(kScan, scans[i].scan());
    const auto matched = matcher.Take<msg::MatchedScan>(kPreChannel);
    ASSERT_EQ(matched.size(), 1U) << i;
    ASSERT_EQ(matched[0]->match().SerializeAsString(), scans[i].match().SerializeAsString()) << i;
    mapper->Feed(kPreChannel, *matched[0]);
    Pass<msg::MapUpdate>(*mapper, matcher, kNextChannel);
    Pass<msg::MapState>(*mapper, matcher, kMapState);
  }
}

// The killed mapper's answer was on its way when the scan was sent to the next one.
TEST(MatcherComponent, FollowsTheMapperThatAnswersLast) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(30);
  MapperHarness mapper;
  MatcherHarness matcher;
  Pass<msg::MapState>(mapper, matcher, kMapState);
  const auto answer = [&](MapperHarness& with, std::size_t scan) {
    with.Feed(kPreChannel, scans[scan]);
    Pass<msg::MapUpdate>(with, matcher, kNextChannel);
  };
  std::optional<hgros::testing::HarnessOptions> checkpoint;
  for (std::size_t i = 0; i < 20; ++i) {
    matcher.Feed(kScan, scans[i].scan());
    answer(mapper, i);
    if (i == 10) checkpoint = {.state = mapper.Save()};
  }
  MapperHarness successor(*checkpoint);
  answer(successor, 19);
  matcher.Feed(kScan, scans[20].scan());
  const auto matched = matcher.Take<msg::MatchedScan>(kPreChannel).back();
  EXPECT_EQ(matcher.status().state, hgros::ComponentState::kRunning) << matcher.status().sentence;
  EXPECT_NE(matched->match().SerializeAsString(), scans[20].match().SerializeAsString()) << "Its map lacks scans.";
}

TEST(WriterComponent, FollowsAMapperThatGoesOnWithAnOlderMap) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(60);
  const hgros::test::ScratchFolder folder;
  hgros::testing::Harness<Writer> writer({.params = "out: " + (folder / "out").string()});
  std::optional<MapperHarness> mapper(std::in_place);
  const auto draw = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i <= last; ++i) mapper->Feed(kPreChannel, scans[i]);
    Pass<msg::MapUpdate>(*mapper, writer, kNextChannel);
  };
  draw(0, 20);
  const auto checkpoint = mapper->Save();
  draw(21, 40);
  mapper.emplace(hgros::testing::HarnessOptions{.state = checkpoint});
  draw(40, 59);  // The matcher sends the last one again.
  msg::MatchedScan end;
  end.mutable_scan()->set_sequence(scans.size());
  end.mutable_scan()->set_end_of_log(true);
  mapper->Feed(kPreChannel, end);
  Pass<msg::MapUpdate>(*mapper, writer, kNextChannel);
  const auto done = writer.Take<msg::Done>(kDone);
  ASSERT_EQ(done.size(), 1U);
  EXPECT_EQ(done[0]->scans(), scans.size());
  OccupancyMap map(Read((*mapper)->Save().map().layout()));
  map.Apply(Read((*mapper)->Save().map()));
  EXPECT_EQ(done[0]->map_hash(), HashMap(map));
}

TEST(MatcherComponent, IgnoresAnUpdateThatIsSentAgain) {
  const std::vector<msg::MatchedScan> scans = MatchedScans(2);
  MapperHarness mapper;
  MatcherHarness matcher;
  Pass<msg::MapState>(mapper, matcher, kMapState);
  matcher.Feed(kScan, scans[0].scan());
  mapper.Feed(kPreChannel, scans[0]);
  const auto update = mapper.Take<msg::MapUpdate>(kNextChannel).front();
  matcher.Feed(kNextChannel, update);
  matcher.Feed(kNextChannel, update);
  matcher.Feed(kScan, scans[1].scan());
  EXPECT_EQ(matcher.status().state, hgros::ComponentState::kRunning);
  const auto matched = matcher.Take<msg::MatchedScan>(kPreChannel);
  ASSERT_EQ(matched.size(), 2U);
  EXPECT_EQ(matched[1]->match().SerializeAsString(), scans[1].match().SerializeAsString());
}

}  // namespace
}  // namespace slam2d

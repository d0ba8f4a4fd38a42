#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "buffers.hpp"
#include "control.hpp"
#include "stamp.hpp"

namespace hgros::bench {
namespace {

Task Parsed(std::vector<std::string> words) {
  words.insert(words.begin(), "peer_test");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  return Task::Parse(static_cast<int>(arguments.size()), arguments.data());
}

// A message of the lane as its sender writes it.
std::vector<std::byte> Message(const Lane& lane, Phase phase, std::uint64_t index) {
  std::vector<std::byte> bytes = FilledBuffer(lane.size_bytes);
  WriteStamp(bytes.data(), bytes.size(), {0, index, lane.index, phase});
  return bytes;
}

class Measurement : public testing::Test {
 protected:
  Task task = Parsed({"both", "mode", "--name", "n", "--port", "7", "--lanes", "64:3:0:0:0:0,128:5:20:2000:4:900"});
  Control& control = OpenControl(task);
};

TEST_F(Measurement, ParsesLanesAndGivesThemNumbersNamesAndPorts) {
  ASSERT_EQ(task.lanes.size(), 2u);
  const Lane& lane = task.lanes[1];
  EXPECT_EQ(lane.size_bytes, 128u);
  EXPECT_EQ(lane.timed, 5);
  EXPECT_EQ(lane.flood_ms, 20);
  EXPECT_EQ(lane.pause_us, 2000);
  EXPECT_EQ(lane.warm_up, 4);
  EXPECT_EQ(lane.transit_us, 900);
  EXPECT_EQ(lane.name, "n_1");
  EXPECT_EQ(lane.port, 8);
}

TEST_F(Measurement, BothSidesAgreeOnTheAddressesOfSenderAndReceiver) {
  const std::vector<std::string> common = {"mode",     "--lanes", "64:1:0:0:0:0", "--own",
                                           "10.0.0.1", "--other", "10.0.0.2"};
  for (const char* role : {"pub", "sub"}) {
    std::vector<std::string> words = {role};
    words.insert(words.end(), common.begin(), common.end());
    const Task side = Parsed(words);
    const bool sends = side.role == Task::Role::kPublish;
    EXPECT_EQ(side.sender_address(), sends ? "10.0.0.1" : "10.0.0.2");
    EXPECT_EQ(side.receiver_address(), sends ? "10.0.0.2" : "10.0.0.1");
  }
}

TEST_F(Measurement, LatencyEndsAtTheLastReceiver) {
  const Lane& lane = task.lanes[0];
  Sink early(lane, control);
  Sink late(lane, control);
  const std::vector<std::byte> message = Message(lane, Phase::kTimed, 1);
  early.Note(message.data(), message.size());
  const std::int64_t first = control.latency_ns[1];
  late.Note(message.data(), message.size());
  EXPECT_GT(first, 0);
  EXPECT_GE(control.latency_ns[1], first);
  EXPECT_EQ(control.timed.Get(), 2u);
  const std::int64_t last = control.latency_ns[1];
  // A shorter time noted later does not change it.
  const std::vector<std::byte> fresh = Message(lane, Phase::kTimed, 1);
  control.latency_ns[1] = last + 1'000'000'000'000;
  early.Note(fresh.data(), fresh.size());
  EXPECT_EQ(control.latency_ns[1], last + 1'000'000'000'000);
}

TEST_F(Measurement, EveryReceiverCountsOneProbe) {
  const Lane& lane = task.lanes[0];
  Sink one(lane, control);
  Sink other(lane, control);
  for (std::uint64_t index = 0; index < 3; ++index) {
    const std::vector<std::byte> probe = Message(lane, Phase::kProbe, index);
    one.Note(probe.data(), probe.size());
    other.Note(probe.data(), probe.size());
  }
  EXPECT_EQ(control.probed.Get(), 2u);
}

TEST_F(Measurement, CountsAlteredMessagesAsDamaged) {
  const Lane& lane = task.lanes[0];
  Sink sink(lane, control);
  std::vector<std::byte> cut = Message(lane, Phase::kTimed, 1);
  sink.Note(cut.data(), cut.size() - 1);
  cut.back() = std::byte{9};
  sink.Note(cut.data(), cut.size());
  const std::vector<std::byte> foreign = Message({1, 64, 0, 0, 0, 0, 0, "", 0}, Phase::kTimed, 1);
  sink.Note(foreign.data(), foreign.size());
  EXPECT_EQ(control.damaged, 3u);
  EXPECT_EQ(control.timed.Get(), 0u);
}

}  // namespace
}  // namespace hgros::bench

#include "transport/outbound_core.hpp"

#include <gtest/gtest.h>

#include "conformance/transport_conformance.hpp"

namespace hgros {
namespace {

class OutboundCoreTest : public testing::Test {
 protected:
  ~OutboundCoreTest() override { core->gate.Close(); }

  std::vector<std::string> lines;
  bool all_are_warnings = true;
  Log log{[&](LogLevel level, std::string_view line) {
    all_are_warnings = all_are_warnings && level == LogLevel::kWarning;
    lines.emplace_back(line);
  }};
  conformance::Source source;
  const std::shared_ptr<OutboundCore> core = std::make_shared<OutboundCore>("scan", conformance::TextType(), source);
  const SessionId eye{1};
  Actions actions;
};

TEST_F(OutboundCoreTest, SaysThatASubscriberIsBackIfItsNextLinkBeginsAtOnce) {
  OutboundCore::CountSubscriber(core, eye, 1, actions);
  core->NoteCommit(log, 7);
  OutboundCore::TellMissed(core, log, eye, "Session 1 (eye)", 2, actions);
  OutboundCore::CountSubscriber(core, eye, -1, actions);
  OutboundCore::CountSubscriber(core, eye, 1, actions);
  for (const auto& action : actions) action();
  core->NoteCommit(log, 10);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_TRUE(all_are_warnings);
  EXPECT_TRUE(lines[0].starts_with("Session 1 (eye) has gone without confirming 2 messages")) << lines[0];
  EXPECT_EQ(lines[1], "Session 1 (eye) has missed up to 4 messages of the lossless channel \"scan\", and is back.");
  EXPECT_EQ(core->stats().missed, 4U) << "the counter and the log say the same";
}

TEST_F(OutboundCoreTest, CountsAllThatASubscriberMissesThatWasBackForNoMessage) {
  OutboundCore::CountSubscriber(core, eye, 1, actions);
  core->NoteCommit(log, 10);
  for (const std::uint64_t unconfirmed : {2U, 3U}) {
    OutboundCore::TellMissed(core, log, eye, "Session 1 (eye)", unconfirmed, actions);
    OutboundCore::CountSubscriber(core, eye, -1, actions);
    core->NoteCommit(log, unconfirmed == 2 ? 20 : 30);
    OutboundCore::CountSubscriber(core, eye, 1, actions);
  }
  core->NoteCommit(log, 31);
  ASSERT_EQ(lines.size(), 1U) << "the actions have not run";
  EXPECT_EQ(lines[0], "Session 1 (eye) has missed up to 25 messages of the lossless channel \"scan\", and is back.");
  EXPECT_EQ(core->stats().missed, 25U);
}

TEST(OutboundCore, NamesASubscriberThatMissesMessagesAgainAndAgainInOneLine) {
  std::vector<std::string> lines;
  std::uint64_t missed = 0;
  {
    conformance::Source source;
    Log log([&](LogLevel, std::string_view line) { lines.emplace_back(line); });
    const auto core = std::make_shared<OutboundCore>("scan", conformance::TextType(), source);
    const SessionId eye{1};
    for (std::uint64_t i = 1; i <= 15; ++i) {
      Actions actions;
      OutboundCore::CountSubscriber(core, eye, 1, actions);
      core->NoteCommit(log, 100 * i);
      OutboundCore::TellMissed(core, log, eye, "Session 1 (eye)", i, actions);
      OutboundCore::CountSubscriber(core, eye, -1, actions);
      for (const auto& action : actions) action();
    }
    missed = core->stats().missed;
    core->gate.Close();
  }
  ASSERT_EQ(lines.size(), 3U) << testing::PrintToString(lines);
  EXPECT_EQ(lines[1], "Session 1 (eye) has missed up to 100 messages of the lossless channel \"scan\", and is back.");
  EXPECT_EQ(lines[2],
            "Session 1 (eye) misses messages of the lossless channel \"scan\" again and again. OutboundStats::missed "
            "counts them.");
  EXPECT_EQ(missed, 15 * 16 / 2 + 14 * 99U);
}

TEST_F(OutboundCoreTest, InventedSubscribersDoNotFillTheLog) {
  for (std::uint64_t i = 1; i <= 400; ++i) {
    const SessionId invented{i};
    const std::string name = "Session " + std::to_string(i);
    Actions due;
    OutboundCore::CountSubscriber(core, invented, 1, due);
    OutboundCore::TellMissed(core, log, invented, name, i, due);
    OutboundCore::CountSubscriber(core, invented, -1, due);
    OutboundCore::CountSubscriber(core, invented, 1, due);
    for (const auto& action : due) action();
    core->NoteCommit(log, i);
  }
  // Ten of each kind.
  EXPECT_EQ(lines.size(), 20U);
}

}  // namespace
}  // namespace hgros

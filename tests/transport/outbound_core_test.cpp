#include "transport/outbound_core.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "conformance/transport_conformance.hpp"

namespace hgros {
namespace {

TEST(OutboundCore, SaysThatASubscriberIsBackIfItsNextLinkBeginsAtOnce) {
  std::vector<std::string> lines;
  Log log([&](LogLevel, std::string_view line) { lines.emplace_back(line); });
  conformance::Source source;
  const auto core = std::make_shared<OutboundCore>("scan", conformance::TextType(), source);
  const SessionId eye{1};
  Actions actions;
  OutboundCore::CountSubscriber(core, eye, 1, actions);
  core->NoteCommit(log, 7);
  OutboundCore::TellMissed(core, log, eye, "Session 1 (eye)", 2, actions);
  OutboundCore::CountSubscriber(core, eye, -1, actions);
  OutboundCore::CountSubscriber(core, eye, 1, actions);
  for (const auto& action : actions) action();
  core->NoteCommit(log, 10);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_TRUE(lines[0].starts_with("Session 1 (eye) has gone without confirming 2 messages")) << lines[0];
  EXPECT_EQ(lines[1], "Session 1 (eye) has missed up to 4 messages of the lossless channel \"scan\", and is back.");
  core->gate.Close();
}

}  // namespace
}  // namespace hgros

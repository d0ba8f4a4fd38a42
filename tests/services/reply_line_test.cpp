#include "services/reply_line.hpp"

#include <gtest/gtest.h>

#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/clock/host_clocks.hpp"
#include "hgros/internal/codec/call_message.hpp"
#include "services/services_fixture.hpp"

namespace hgros {
namespace {

TEST(ReplyLine, LogsDroppedRepliesWhenTooManyWaitForTheCaller) {
  int said = 0;
  const auto log = std::make_shared<Log>([&](LogLevel, std::string_view) { ++said; });
  const TypeInfo& type = CallTypeOf<test::Total>();
  const auto outlet = std::make_shared<ChannelOutlet>("replies", type, MessageId{1, 1, 0}, log, OutletEvents{},
                                                      std::make_shared<HostClocks>());
  int soon = 0;
  ReplyLine line(outlet, type, log, "add", [&] { ++soon; });
  const auto reply = std::make_shared<const CallMessage>();
  for (std::size_t i = 0; i < ReplyLine::kMaxWaiting; ++i) ASSERT_TRUE(line.Send(reply));
  EXPECT_EQ(soon, static_cast<int>(ReplyLine::kMaxWaiting));
  EXPECT_EQ(said, 0);
  EXPECT_FALSE(line.Send(reply));
  EXPECT_EQ(said, 1);
  EXPECT_EQ(line.Close(), ReplyLine::kMaxWaiting);
  EXPECT_FALSE(line.Send(reply));
  EXPECT_EQ(said, 1);
}

}  // namespace
}  // namespace hgros

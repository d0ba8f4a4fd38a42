// Messages whose topic frame was changed on the way, without keys: by a proxy, or by bad hardware.
#include <gtest/gtest.h>

#include <memory>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "support/await.hpp"
#include "transport/zmq_places.hpp"
#include "transport/zmq_spoiler.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::TextType;
using test::Place;
using test::Spoiler;

constexpr std::string_view kBegin("scan\x01", 5);  // Of the topic frame. The session's id and the number follow.
constexpr std::size_t kIdBytes = 16;
constexpr std::size_t kNumberBytes = 8;

struct Change {
  const char* name;
  std::size_t offset;  // In the topic frame.
  char bits;

  friend void PrintTo(const Change& change, std::ostream* out) { *out << change.name; }
};

class ZmqGap : public testing::TestWithParam<Change> {
 protected:
  ZmqGap()
      : server_(test::PublishAt("tcp://127.0.0.1:*")),
        spoiler_(server_.transport->BoundEndpoints().front(), Spoiler::Side::kServer, Spoiler::Then::kGoesOn,
                 [](std::span<char> bytes) {
                   const std::size_t at = std::string_view(bytes.data(), bytes.size()).find(kBegin);
                   if (at == std::string_view::npos) return false;
                   if (bytes.size() - at < kBegin.size() + kIdBytes + kNumberBytes) return false;
                   bytes[at + GetParam().offset] ^= GetParam().bits;
                   return true;
                 }),
        out_(server_.transport->Advertise("scan", TextType(), source_)),
        client_(test::SubscribeAt(spoiler_.endpoint())) {}

  bool Publish(const std::string& text) {
    PacketHead head;
    head.channel = "scan";
    head.encoding = Encoding::kCustom;
    if (out_->Reserve() != PublishStatus::kOk) return false;
    out_->Commit(head, conformance::Publication::PayloadOf(text));
    return true;
  }
  bool PublishSoon(const std::string& text) {
    return test::Await([&] { return Publish(text); });
  }

  conformance::Source source_;
  Place server_;
  Spoiler spoiler_;
  std::unique_ptr<OutboundChannel> out_;
  Place client_;
  conformance::Sink sink_;
};

TEST_P(ZmqGap, ALosslessSubscriberGetsAllMessagesOnce) {
  Demand demand;
  demand.lossless = true;
  demand.credit_messages = 8;
  conformance::Sink whole;
  Place other(test::SubscribeAt(server_.transport->BoundEndpoints().front()));
  const auto in = client_.transport->Subscribe("scan", TextType(), demand, sink_);
  const auto in_other = other.transport->Subscribe("scan", TextType(), demand, whole);
  ASSERT_TRUE(Eventually([&] { return out_->subscriber_count() == 2; }));
  std::vector<std::string> sent;
  for (int i = 0; i < 100; ++i) {
    sent.push_back(std::to_string(i));
    if (i == 50) spoiler_.Spoil();
    ASSERT_TRUE(PublishSoon(sent.back())) << i;
  }
  EXPECT_TRUE(Eventually([&] { return sink_.count() == sent.size() && whole.count() == sent.size(); }));
  EXPECT_EQ(sink_.texts(), sent);
  EXPECT_EQ(whole.texts(), sent);
  EXPECT_FALSE(spoiler_.spoils());
  EXPECT_EQ(spoiler_.connections(), 2);
  EXPECT_TRUE(client_.Said("so the connection is made again"));
}

TEST_P(ZmqGap, AKeepLastSubscriberGoesOn) {
  const auto in = client_.transport->Subscribe("scan", TextType(), {}, sink_);
  ASSERT_TRUE(Eventually([&] { return out_->subscriber_count() == 1; }));
  ASSERT_TRUE(PublishSoon("first"));
  ASSERT_TRUE(Eventually([&] { return sink_.count() == 1; }));
  spoiler_.Spoil();
  ASSERT_TRUE(test::Await([&] {
    (void)Publish("spoilt");
    return !spoiler_.spoils();
  }));
  EXPECT_TRUE(test::Await([&] {
    (void)Publish("again");
    const auto texts = sink_.texts();
    return texts.back() == "again";
  }));
}

INSTANTIATE_TEST_SUITE_P(Changed, ZmqGap,
                         testing::Values(Change{"Channel", 0, 1}, Change{"Kind", 4, 2}, Change{"Session", 5, 1},
                                         Change{"LargerNumber", kBegin.size() + kIdBytes + 1, 1},
                                         Change{"SmallerNumber", kBegin.size() + kIdBytes, 32}),
                         [](const auto& change) { return std::string(change.param.name); });

}  // namespace
}  // namespace hgros

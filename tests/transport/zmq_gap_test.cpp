// Messages whose topic frame was changed on the way, without keys: by a proxy, or by bad hardware.
#include <gtest/gtest.h>

#include <span>

#include "transport/zmq_places.hpp"
#include "transport/zmq_spoiler.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::Reception;
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
  static bool Spoil(std::span<char> bytes) {
    const std::size_t at = std::string_view(bytes.data(), bytes.size()).find(kBegin);
    if (at == std::string_view::npos) return false;
    if (bytes.size() - at < kBegin.size() + kIdBytes + kNumberBytes) return false;
    bytes[at + GetParam().offset] ^= GetParam().bits;
    return true;
  }

  Place server_{test::PublishAt()};
  Spoiler spoiler_{server_.Bound(), Spoiler::Side::kServer, Spoiler::Then::kGoesOn, Spoil};
  conformance::Publication out_{*server_.transport, "scan"};
  Place client_{test::SubscribeAt(spoiler_.endpoint())};
};

TEST_P(ZmqGap, ALosslessSubscriberGetsAllMessagesOnce) {
  const Demand demand{.lossless = true, .credit_messages = 8};
  Place other(test::SubscribeAt(server_.Bound()));
  const Reception in(*client_.transport, "scan", TextType(), demand);
  const Reception whole(*other.transport, "scan", TextType(), demand);
  ASSERT_TRUE(out_.Joined(2));
  std::vector<std::string> sent;
  for (int i = 0; i < 100; ++i) {
    sent.push_back(std::to_string(i));
    if (i == 50) spoiler_.Spoil();
    ASSERT_TRUE(out_.PublishSoon(sent.back())) << i;
  }
  EXPECT_TRUE(Eventually([&] { return in.sink.count() == sent.size() && whole.sink.count() == sent.size(); }));
  EXPECT_EQ(in.sink.texts(), sent);
  EXPECT_EQ(whole.sink.texts(), sent);
  EXPECT_FALSE(spoiler_.spoils());
  EXPECT_EQ(spoiler_.connections(), 2);
  EXPECT_TRUE(client_.Said("so the connection is made again"));
}

TEST_P(ZmqGap, AKeepLastSubscriberGoesOn) {
  const Reception in(*client_.transport, "scan");
  ASSERT_TRUE(out_.Joined());
  ASSERT_TRUE(out_.PublishSoon("first"));
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  spoiler_.Spoil();
  ASSERT_TRUE(Eventually([&] {
    (void)out_.Publish("spoilt");
    return !spoiler_.spoils();
  }));
  EXPECT_TRUE(Eventually([&] {
    (void)out_.Publish("again");
    return in.sink.texts().back() == "again";
  }));
}

INSTANTIATE_TEST_SUITE_P(Changed, ZmqGap,
                         testing::Values(Change{"Channel", 0, 1}, Change{"Kind", 4, 2}, Change{"Session", 5, 1},
                                         Change{"LargerNumber", kBegin.size() + kIdBytes + 1, 1},
                                         Change{"SmallerNumber", kBegin.size() + kIdBytes, 32}),
                         [](const auto& change) { return std::string(change.param.name); });

}  // namespace
}  // namespace hgros

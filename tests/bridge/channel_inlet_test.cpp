#include "hgros/bridge/channel_inlet.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include <foxglove/Log.pb.h>

#include "hgros/codec/message.hpp"

namespace hgros::test {

/// A message with its own codec and the wire form of foxglove.Log.
struct Line {
  std::string text;
  static inline std::function<void()> on_parse;  // Called once in its codec, if not empty.
};

}  // namespace hgros::test

template <>
struct hgros::CustomCodec<hgros::test::Line> {
  using Schema = foxglove::Log;
  static bool Serialize(const test::Line& line, std::string& bytes) {
    bytes = line.text;
    return true;
  }
  static bool Parse(std::string_view bytes, test::Line& line) {
    line.text = bytes;
    if (const auto call = std::exchange(test::Line::on_parse, nullptr)) call();
    return true;
  }
};

namespace hgros {
namespace {

/// An inlet between a graph and this thread, which stands for the transport's thread.
template <class T>
struct Inflow {
  explicit Inflow(std::string name = "lines") : channel(std::move(name)) {}
  [[nodiscard]] Accepted Accept(const std::string& text, std::uint32_t latched = 0) {
    foxglove::Log log;
    log.set_message(text);
    const auto bytes = std::make_shared<const std::string>(log.SerializeAsString());
    InboundMessage message;
    message.head.channel = channel;
    message.head.id = {7, 1, ++sequence};
    message.head.latched = latched;
    message.head.publish_time_ns = publish_time_ns;
    message.head.cause = cause;
    message.from = from;
    message.data = {AsBytes(*bytes), bytes};
    return inlet.Accept(std::move(message));
  }
  [[nodiscard]] Subscription Listen(Executor executor = Executor::Inline()) {
    return graph.FromGraph<T>(channel, Invoke::kSerial, [this](const T& log) { got.push_back(log.message()); },
                              {{}, {}, std::move(executor)});
  }
  void RunErrands() {
    for (const auto& errand : std::exchange(errands, {})) errand();
  }
  void RunAll() {
    inlet.Run();
    RunErrands();
  }
  void Receive(std::int64_t published_at_ns = 0) {
    publish_time_ns = published_at_ns;
    (void)Accept("x");
    RunAll();
  }
  /// From now on its only publisher is session 5, and no message may be lost.
  void SetLossless() {
    from = SessionId{5};
    inlet.SetDemand({.lossless = true});
  }

  const std::string channel;
  std::vector<std::string> got;
  std::vector<std::string> lines;  // Of the log.
  std::vector<ChannelInlet::Errand> errands;
  std::uint64_t sequence = 0;
  std::int64_t publish_time_ns = 0;
  CauseHead cause;
  SessionId from;
  DataGraph graph;
  ChannelInlet inlet{graph.Open(channel, TypeOf<T>(), CallSite::Current()),
                     false,
                     std::make_shared<Log>([this](LogLevel, std::string_view line) { lines.emplace_back(line); }),
                     [] {},
                     [this](ChannelInlet::Errand errand) { errands.push_back(std::move(errand)); },
                     [](const std::string&, const PeerInfo&, const std::string&) {},
                     std::make_shared<HostClocks>()};
};

using Texts = std::vector<std::string>;

TEST(ChannelInlet, DoesNotRunAnInlineNodeThatCameAfterAcceptOnTheTransportsThread) {
  for (const std::uint32_t latched : {0U, 5U}) {
    Inflow<foxglove::Log> inflow;
    ASSERT_EQ(inflow.Accept("1", latched), Accepted::kRunHere);
    const auto subscription = inflow.Listen();
    EXPECT_EQ(inflow.Accept("2", latched), Accepted::kNothing);
    inflow.inlet.Run();
    EXPECT_EQ(inflow.got, Texts{}) << "this is the transport's thread";
    EXPECT_EQ(inflow.Accept("3", latched), Accepted::kNothing) << "it comes after the messages that were handed over";
    inflow.RunErrands();
    EXPECT_EQ(inflow.got, (Texts{"1", "2", "3"}));
    EXPECT_EQ(inflow.Accept("4", latched), Accepted::kRunApart);
    inflow.inlet.Run();
    EXPECT_EQ(inflow.got.size(), 4U);
    EXPECT_TRUE(inflow.errands.empty());
  }
}

TEST(ChannelInlet, DoesNotDecodeALargeMessageBehindASmallOneOnTheTransportsThread) {
  Inflow<foxglove::Log> inflow;
  ASSERT_EQ(inflow.Accept("1"), Accepted::kRunHere);
  const std::string large(1 << 20, 'x');
  EXPECT_EQ(inflow.Accept(large), Accepted::kNothing);
  inflow.inlet.Run();
  const auto subscription = inflow.Listen();
  EXPECT_EQ(inflow.errands.size(), 1U);
  inflow.RunErrands();
  EXPECT_EQ(inflow.got, Texts{large});
}

// A peer may write any numbers, and its clock may show any time.
TEST(ChannelInlet, LimitsTheAgeOfAChainToOneDayAndNeverBeginsItInTheFuture) {
  constexpr std::int64_t kDayNs = 24 * 3600 * std::int64_t{1'000'000'000};
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t publish_time_ns : {std::int64_t{0}, std::int64_t{1}, std::int64_t{-1}, kMost, -kMost}) {
    for (const std::uint64_t age : {std::uint64_t{0}, std::uint64_t{5}, ~std::uint64_t{0}, std::uint64_t{1} << 63U}) {
      Inflow<foxglove::Log> inflow;
      inflow.publish_time_ns = publish_time_ns;
      inflow.cause = {3, age, 4, std::numeric_limits<std::int64_t>::min()};
      std::optional<MessageInfo> got;
      const Subscription subscription = inflow.graph.FromGraph<foxglove::Log>(
          "lines", Invoke::kSerial, [&](const foxglove::Log&, const MessageInfo& info) { got = info; },
          {{}, {}, Executor::Inline()});
      (void)inflow.Accept("x");
      inflow.inlet.Run();
      ASSERT_TRUE(got.has_value());
      EXPECT_EQ(got->cause.message, 3U);
      EXPECT_EQ(got->cause.origin, 4U);
      EXPECT_LE(got->cause.began_ns, got->publish_monotonic_ns);
      EXPECT_LE(got->publish_monotonic_ns - got->cause.began_ns, kDayNs);
      if (publish_time_ns == 0 && age == 5) {
        EXPECT_EQ(got->publish_monotonic_ns - got->cause.began_ns, 5);
      }
    }
  }
}

TEST(ChannelInlet, LetsOtherErrandsRunInBetween) {
  Inflow<foxglove::Log> inflow;
  ASSERT_EQ(inflow.Accept("1"), Accepted::kRunHere);
  const auto subscription = inflow.Listen();
  for (int i = 2; i <= 100; ++i) EXPECT_EQ(inflow.Accept(std::to_string(i)), Accepted::kNothing);
  inflow.inlet.Run();
  int rounds = 0;
  for (; !inflow.errands.empty(); ++rounds) inflow.RunErrands();
  EXPECT_GT(rounds, 1);
  ASSERT_EQ(inflow.got.size(), 100U);
  EXPECT_EQ(inflow.got.back(), "100");
}

TEST(ChannelInlet, ForgetsHandedOverMessagesWhenDetachedAndStartsAgain) {
  Inflow<foxglove::Log> inflow;
  ASSERT_EQ(inflow.Accept("1"), Accepted::kRunHere);
  const auto subscription = inflow.Listen();
  inflow.inlet.Run();
  inflow.inlet.Detach();
  EXPECT_EQ(inflow.Accept("2"), Accepted::kNothing);
  inflow.RunErrands();
  EXPECT_EQ(inflow.got, Texts{"2"});
  EXPECT_EQ(inflow.Accept("3"), Accepted::kRunApart);
}

TEST(ChannelInlet, DoesNotDeliverToTheNextSubscriptionWhatWasDecodedWhenTheLastOneEnded) {
  Inflow<test::Line> inflow;
  int got = 0;
  const auto count = [&got](const test::Line&) { ++got; };
  const NodeOptions inline_node{{}, {}, Executor::Inline()};
  std::optional<Subscription> last = inflow.graph.FromGraph<test::Line>("lines", Invoke::kSerial, count, inline_node);
  std::optional<Subscription> next;
  test::Line::on_parse = [&] {
    last.reset();
    inflow.inlet.Detach();
    next = inflow.graph.FromGraph<test::Line>("lines", Invoke::kSerial, count, inline_node);
  };
  ASSERT_EQ(inflow.Accept("1"), Accepted::kRunApart);
  inflow.inlet.Run();
  EXPECT_EQ(got, 0) << "it is older than the subscription";
  inflow.sequence = 6;
  ASSERT_EQ(inflow.Accept("7"), Accepted::kRunApart);
  inflow.inlet.Run();
  EXPECT_EQ(got, 1);
  EXPECT_EQ(inflow.lines, Texts{}) << "2 to 6 were published while there was no subscription";
}

TEST(ChannelInlet, GivesTheNextSubscriptionNothingThatComesOverTheLinkOfTheLastOne) {
  Inflow<foxglove::Log> inflow;
  EXPECT_EQ(inflow.Accept("1"), Accepted::kRunHere);
  EXPECT_EQ(inflow.inlet.Leave().size(), 1U);
  const auto next = inflow.Listen();
  inflow.inlet.Run();
  EXPECT_EQ(inflow.Accept("2"), Accepted::kNothing);
  inflow.inlet.Detach();
  EXPECT_EQ(inflow.Accept("5"), Accepted::kRunApart);
  inflow.inlet.Run();
  EXPECT_TRUE(inflow.errands.empty());
  EXPECT_EQ(inflow.got, Texts{"5"});
}

TEST(ChannelInlet, MakesOneSchemaForEachOfSeveralPlainPublishers) {
  DataGraph graph;
  Channel& channel = graph.Open("any", AnyType(), CallSite::Current());
  std::vector<std::shared_ptr<const RawMessage>> got;
  NodeOptions options;
  options.executor = Executor::Inline();
  const auto subscription = graph.Subscribe(
      channel, AnyType(), Invoke::kSerial,
      [&](const AnyMessage& message, const MessageInfo&) {
        got.push_back(std::static_pointer_cast<const RawMessage>(message));
      },
      options);
  ChannelInlet inlet(
      channel, false, std::make_shared<Log>(), [] {}, [](const ChannelInlet::Errand&) {},
      [](const std::string&, const PeerInfo&, const std::string&) {}, std::make_shared<HostClocks>());
  for (int i = 0; i < 200; ++i) {
    InboundMessage message;
    message.head.channel = "any";
    // The first two names alternate; the rest are new in each message.
    message.head.type_name = i < 100 ? (i % 2 == 0 ? "a.A" : "b.B") : "c.C" + std::to_string(i);
    message.head.encoding = Encoding::kCustom;
    ASSERT_EQ(inlet.Accept(std::move(message)), Accepted::kRunApart);
    inlet.Run();
  }
  ASSERT_EQ(got.size(), 200U);
  for (std::size_t i = 2; i < 100; ++i) EXPECT_EQ(got[i]->schema, got[i - 2]->schema);
  EXPECT_NE(got[0]->schema, got[1]->schema);
  EXPECT_EQ(got[199]->schema->type_name, "c.C199");
}

TEST(ChannelInlet, SaysThatAPublisherWasCutOffOnlyIfItsLinkHasEnded) {
  for (const bool cut : {false, true}) {
    Inflow<foxglove::Log> inflow;
    inflow.SetLossless();
    inflow.Receive();
    inflow.inlet.OnOfferEnded(SessionId{cut ? 5U : 6U}, OfferEnd::kLost);
    inflow.Receive();  // It had arrived before.
    EXPECT_TRUE(inflow.lines.empty());
    inflow.sequence += 3;
    inflow.Receive();
    ASSERT_EQ(inflow.lines.size(), 1U);
    EXPECT_EQ(inflow.lines[0],
              std::string("3 messages of the lossless channel \"lines\" did not arrive: ") +
                  (cut ? "the connection to their publisher was lost, and they were published before it was back."
                       : "their publisher was connected, but could not send them. Its log says why."));
  }
}

// The end of the offer may reach this session after the publisher offers the channel again, so times do not tell.
TEST(ChannelInlet, CountsNothingAsLostBeforeTheFirstMessageAfterAWithdrawnOffer) {
  constexpr std::int64_t kMinute = 60'000'000'000;
  for (const std::int64_t published_after : {-kMinute, kMinute}) {
    for (const bool waits : {false, true}) {  // For a thread, when the offer ends.
      Inflow<foxglove::Log> inflow;
      inflow.SetLossless();
      const std::int64_t now = WallNow().nanoseconds;
      const auto accept = [&](std::int64_t publish_time_ns) {
        inflow.publish_time_ns = publish_time_ns;
        (void)inflow.Accept("x");
      };
      inflow.Receive(now - 2 * kMinute);
      inflow.sequence += 3;
      if (waits) accept(now + published_after);
      inflow.inlet.OnOfferEnded(SessionId{5}, OfferEnd::kWithdrawn);
      if (!waits) accept(now + published_after);
      inflow.RunAll();
      EXPECT_EQ(inflow.lines.size(), waits ? 1U : 0U);
      inflow.sequence += 3;
      inflow.Receive(now + 2 * kMinute);
      ChannelTraffic traffic;
      inflow.inlet.AddTo(traffic);
      ASSERT_EQ(traffic.in.size(), 1U);
      EXPECT_EQ(traffic.in[0].lost, 3U) << "the offer has ended once";
    }
  }
}

TEST(ChannelInlet, CountsNothingAsLostAfterMessagesOfAnEarlierSubscriptionWereDropped) {
  Inflow<foxglove::Log> inflow;
  inflow.SetLossless();
  for (int i = 0; i < 4; ++i) (void)inflow.Accept("x");
  inflow.inlet.OnOfferEnded(SessionId{5}, OfferEnd::kWithdrawn);
  inflow.inlet.Detach();
  for (int i = 0; i < 2; ++i) {
    if (i == 1) inflow.inlet.OnOfferEnded(SessionId{5}, OfferEnd::kWithdrawn);
    inflow.sequence += 3;
    (void)inflow.Accept("x");
    inflow.inlet.Run();
    EXPECT_TRUE(inflow.lines.empty());
  }
}

TEST(ChannelInlet, ForgetsTheEndOfALinkWhenALaterMessageArrivesWithoutAGap) {
  for (const bool later : {false, true}) {
    Inflow<foxglove::Log> inflow;
    inflow.SetLossless();
    constexpr std::int64_t kMinute = 60'000'000'000;
    const std::int64_t now = WallNow().nanoseconds;
    inflow.Receive(now - 2 * kMinute);
    inflow.inlet.OnOfferEnded(SessionId{5}, OfferEnd::kLost);
    inflow.Receive(later ? now + kMinute : now - kMinute);
    inflow.sequence += 3;
    inflow.Receive(now + 2 * kMinute);
    ASSERT_EQ(inflow.lines.size(), 1U);
    EXPECT_EQ(inflow.lines[0].find("was connected, but could not send them") != std::string::npos, later)
        << inflow.lines[0];
  }
}

TEST(ChannelInlet, DropsMessagesOfTheLibrarysChannelsThatTheirPublisherHasNotSent) {
  Inflow<foxglove::Log> inflow("hgros/lines");
  const auto heard = inflow.Listen();
  for (const SessionId from : {SessionId{}, SessionId{5}, SessionId{}, SessionId{7}}) {  // All name 7.
    inflow.from = from;
    (void)inflow.Accept(from.ToString());
    inflow.inlet.Run();
  }
  EXPECT_EQ(inflow.got, Texts{SessionId{7}.ToString()});
  ChannelTraffic traffic;
  inflow.inlet.AddTo(traffic);
  EXPECT_EQ(traffic.faults[static_cast<std::size_t>(PacketFault::kHead)], 3U);
  ASSERT_EQ(inflow.lines.size(), 1U);
  EXPECT_NE(inflow.lines[0].find("names a publisher that has not sent it"), std::string::npos) << inflow.lines[0];
  Inflow<foxglove::Log> other;
  const auto plain = other.Listen();
  other.Receive();
  EXPECT_EQ(other.got, Texts{"x"}) << "plain publishers may use other channels";
}

TEST(ChannelInlet, RunsAUserCodecOffTheTransportsThreadEvenForProtobufBytes) {
  Inflow<test::Line> inflow;
  EXPECT_EQ(inflow.Accept("1"), Accepted::kRunApart);
}

}  // namespace
}  // namespace hgros

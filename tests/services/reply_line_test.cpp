#include "services/reply_line.hpp"

#include <gmock/gmock.h>

#include "hgros/internal/codec/call_message.hpp"
#include "hgros/services/service_place.hpp"
#include "hgros/services/services.hpp"
#include "services/services_fixture.hpp"

namespace hgros::test {
namespace {

using testing::ElementsAre;
using Moment = ReplyLine::Moment;

/// Keeps what is sent to a caller that subscribes.
struct KeepingOutlet : SessionOutlet {
  [[nodiscard]] bool wanted() const noexcept override { return true; }
  PublishStatus Reserve(const void*, const TypeInfo&, PreparedMessage&) noexcept override { return PublishStatus::kOk; }
  bool Commit(const AnyMessage& message, const TypeInfo&, const MessageInfo&, PreparedMessage&&) noexcept override {
    sent.push_back(*static_cast<const CallMessage*>(message.get()));
    ++count;
    return true;
  }
  void Cancel() noexcept override {}
  [[nodiscard]] std::size_t subscriber_count() const noexcept override { return 1; }
  [[nodiscard]] std::vector<SessionId> Subscribers() const override { return {SessionId{2}}; }

  std::vector<CallMessage> sent;  // Read by another thread after `count` says so.
  std::atomic<int> count{0};
};

/// Its caller subscribes when the test says so.
struct SwitchOutlet final : KeepingOutlet {
  PublishStatus Reserve(const void*, const TypeInfo&, PreparedMessage&) noexcept override {
    return takes ? PublishStatus::kOk : PublishStatus::kFull;
  }
  [[nodiscard]] std::size_t subscriber_count() const noexcept override { return subscribed ? 1 : 0; }

  bool subscribed = false;
  bool takes = false;
};

/// A line and what it asks for. At first, its caller does not subscribe.
class Line {
 public:
  explicit Line(std::shared_ptr<ServiceRoom> room = std::make_shared<ServiceRoom>()) : room_(std::move(room)) {}

  [[nodiscard]] static std::shared_ptr<const CallMessage> Reply(std::uint64_t call) {
    auto reply = std::make_shared<CallMessage>();
    reply->call = call;
    reply->body = std::make_shared<const Total>();
    reply->type = &TypeOf<Total>();
    return reply;
  }

  const std::shared_ptr<SwitchOutlet> outlet = std::make_shared<SwitchOutlet>();
  int soon = 0;
  std::vector<Moment> asked;
  std::vector<std::string> said;

 private:
  const std::shared_ptr<ServiceRoom> room_;
  const std::shared_ptr<Log> log_ =
      std::make_shared<Log>([this](LogLevel, std::string_view text) { said.emplace_back(text); });
  const TypeInfo& type_ = CallTypeOf<Total>();

 public:
  ReplyLine line{outlet,
                 type_,
                 log_,
                 "add",
                 "arm",
                 room_,
                 {[this] { ++soon; }, [this](Moment when) { asked.push_back(when); },
                  [](bool subscribed) { return subscribed ? "slow" : "away"; }}};
};

std::shared_ptr<ServiceRoom> RoomFor(std::size_t of_caller, std::size_t of_all) {
  const std::size_t one = BytesOf(*Line::Reply(0));
  const auto room = std::make_shared<ServiceRoom>();
  room->caller_bytes = of_caller * one;
  room->service_bytes = of_all * one;
  room->fresh = std::chrono::hours(1);
  return room;
}

const std::string kDropped = "A reply of service \"add\" to session arm was dropped: ";

TEST(ReplyLine, LogsDroppedRepliesWhenTooManyWaitForTheCaller) {
  const auto room = std::make_shared<ServiceRoom>();
  room->fresh = std::chrono::milliseconds(0);
  Line to(room);
  const auto reply = std::make_shared<const CallMessage>();
  for (std::size_t i = 0; i < ReplyLine::kMaxWaiting; ++i) ASSERT_TRUE(to.line.Send(reply));
  EXPECT_EQ(to.soon, static_cast<int>(ReplyLine::kMaxWaiting));
  EXPECT_EQ(to.said.size(), 0U);
  EXPECT_FALSE(to.line.Send(reply));
  EXPECT_THAT(to.said, ElementsAre(kDropped + "64 MiB, or 65536 replies, wait for the caller already. away"));
  EXPECT_EQ(to.line.Close(), ReplyLine::kMaxWaiting + 1) << "the refusal waits";
  EXPECT_FALSE(to.line.Send(reply));
  EXPECT_EQ(to.said.size(), 1U);
}

TEST(ReplyLine, LimitsTheBytesThatWait) {
  const auto room = RoomFor(10, 15);
  const std::size_t one = BytesOf(*Line::Reply(0));
  EXPECT_GT(one, sizeof(Total));
  Line to(room);
  Line other(room);
  for (std::uint64_t i = 0; i < 10; ++i) EXPECT_TRUE(to.line.Send(Line::Reply(i))) << i;
  EXPECT_FALSE(to.line.Send(Line::Reply(10)));
  EXPECT_EQ(to.said.size(), 1U);
  for (std::uint64_t i = 0; i < 7; ++i) EXPECT_TRUE(other.line.Send(Line::Reply(i))) << i;
  EXPECT_EQ(room->reply_bytes, 15 * one);
  EXPECT_FALSE(other.line.Send(Line::Reply(7))) << "the other line holds no more";
  EXPECT_EQ(to.line.Flush(), 2U) << "given up for the other line";
  EXPECT_EQ(to.line.Flush(), 0U);
  EXPECT_EQ(to.line.Close(), 11U);
  EXPECT_TRUE(other.line.Send(Line::Reply(8)));
  EXPECT_EQ(room->reply_bytes, 8 * one);
  EXPECT_EQ(other.line.Close(), 9U);
  EXPECT_EQ(room->reply_bytes, 0U);
}

TEST(ReplyLine, GivesUpItsOldestRepliesForACallerThatHoldsLess) {
  const auto room = RoomFor(10, 10);
  Line most(room);
  Line newcomer(room);
  for (std::uint64_t i = 0; i < 10; ++i) EXPECT_TRUE(most.line.Send(Line::Reply(i))) << i;
  const int soon = most.soon;
  EXPECT_TRUE(newcomer.line.Send(Line::Reply(1)));
  EXPECT_TRUE(newcomer.line.Send(Line::Reply(2)));
  EXPECT_TRUE(newcomer.said.empty());
  EXPECT_GT(most.soon, soon) << "it must say what it has lost";
  EXPECT_EQ(most.line.Flush(), 2U);
  EXPECT_THAT(most.said,
              ElementsAre(kDropped + "0 MiB of replies waited for all callers. Its subscription has not arrived yet."));
  most.outlet->subscribed = most.outlet->takes = true;
  EXPECT_EQ(most.line.Flush(), 0U);
  ASSERT_EQ(most.outlet->sent.size(), 10U);
  EXPECT_EQ(most.outlet->sent[1].call, 1U);
  EXPECT_EQ(most.outlet->sent[1].outcome, CallMessage::Outcome::kNotWritable);
  EXPECT_EQ(most.outlet->sent[1].text, "The reply was dropped: 0 MiB of replies waited for all callers.");
  EXPECT_EQ(most.outlet->sent[2].outcome, CallMessage::Outcome::kOk);
}

TEST(ReplyLine, GivesUpRepliesForOthersFirstIfItsCallerHasNotSubscribedForAWhile) {
  const auto room = RoomFor(10, 6);
  room->fresh = std::chrono::milliseconds(1);
  Line away(room);
  Line slow(room);
  slow.outlet->subscribed = true;
  for (std::uint64_t i = 0; i < 2; ++i) EXPECT_TRUE(away.line.Send(Line::Reply(i))) << i;
  const Moment later = std::chrono::steady_clock::now() + room->fresh;
  ASSERT_TRUE(Await([&] { return std::chrono::steady_clock::now() > later; }));
  for (std::uint64_t i = 0; i < 6; ++i) EXPECT_TRUE(slow.line.Send(Line::Reply(i))) << i;
  EXPECT_FALSE(slow.line.Send(Line::Reply(6))) << "nothing is left to take";
  EXPECT_EQ(slow.said.size(), 1U);
  EXPECT_EQ(away.line.Flush(), 2U);
  ASSERT_EQ(away.said.size(), 1U);
  EXPECT_TRUE(away.said[0].ends_with(" away")) << away.said[0];
}

TEST(ReplyLine, TellsTheLimitThatWasReached) {
  const auto room = std::make_shared<ServiceRoom>();
  room->service_bytes = BytesOf(*Line::Reply(0)) + (3U << 20U);
  room->fresh = std::chrono::hours(1);
  Line to(room);
  EXPECT_TRUE(to.line.Send(Line::Reply(0)));
  room->reply_bytes += 3U << 20U;  // Another caller's, on their way.
  EXPECT_FALSE(to.line.Send(Line::Reply(1)));
  EXPECT_THAT(
      to.said,
      ElementsAre(kDropped + "3 MiB of replies wait for all callers already. Its subscription has not arrived yet."));
  to.outlet->subscribed = to.outlet->takes = true;
  EXPECT_EQ(to.line.Flush(), 0U);
  ASSERT_EQ(to.outlet->sent.size(), 2U);
  EXPECT_EQ(to.outlet->sent[1].text, "The reply was dropped: 3 MiB of replies wait for all callers already.");
}

TEST(ReplyLine, RefusesRepliesThatHaveWaitedTooLongForASubscription) {
  const auto room = std::make_shared<ServiceRoom>();
  room->away = std::chrono::milliseconds(40);
  Line to(room);
  Line slow(room);
  slow.outlet->subscribed = true;
  EXPECT_TRUE(to.line.Send(Line::Reply(7)));
  EXPECT_TRUE(slow.line.Send(Line::Reply(7)));
  ASSERT_EQ(to.asked.size(), 1U);
  ASSERT_EQ(slow.asked.size(), 1U);
  ASSERT_TRUE(Await([&] { return std::chrono::steady_clock::now() >= std::max(to.asked[0], slow.asked[0]); }));
  EXPECT_EQ(slow.line.Flush(), 0U) << "its caller has subscribed";
  EXPECT_EQ(to.line.Flush(), 1U);
  EXPECT_EQ(room->reply_bytes, BytesOf(*Line::Reply(7)));
  EXPECT_THAT(to.said, ElementsAre(kDropped + "the caller did not subscribe to it in time. away"));
  EXPECT_EQ(to.asked.size(), 1U) << "a refusal has no such time";
  to.outlet->subscribed = to.outlet->takes = true;
  EXPECT_EQ(to.line.Flush(), 0U);
  ASSERT_EQ(to.outlet->sent.size(), 1U);
  EXPECT_EQ(to.outlet->sent[0].outcome, CallMessage::Outcome::kNotWritable);
  EXPECT_EQ(to.outlet->sent[0].call, 7U);
}

TEST(ReplyLine, KeepsOneReplyOfAnySize) {
  const auto room = std::make_shared<ServiceRoom>();
  room->caller_bytes = room->service_bytes = 1;
  Line to(room);
  EXPECT_TRUE(to.line.Send(Line::Reply(0)));
  EXPECT_FALSE(to.line.Send(Line::Reply(1)));
  Line other(room);
  EXPECT_FALSE(other.line.Send(Line::Reply(0))) << "the service has no room";
}

TEST(ReplyLine, DropsRepliesWhoseCallsHaveTimedOut) {
  const auto room = std::make_shared<ServiceRoom>();
  Line to(room);
  const Moment due = std::chrono::steady_clock::now() + std::chrono::milliseconds(40);
  EXPECT_TRUE(to.line.Send(Line::Reply(0), due));
  EXPECT_TRUE(to.line.Send(Line::Reply(1), due));
  EXPECT_TRUE(to.line.Send(Line::Reply(2), due + kLong));
  EXPECT_TRUE(to.line.Send(Line::Reply(3)));
  ASSERT_EQ(to.asked.size(), 1U) << "one look at a time";
  ASSERT_TRUE(Await([&] { return std::chrono::steady_clock::now() >= to.asked[0]; }));
  EXPECT_EQ(to.line.Flush(), 2U);
  EXPECT_THAT(to.said, ElementsAre(kDropped + "it still waited when its call had timed out. away"));
  EXPECT_EQ(room->reply_bytes, 2 * BytesOf(*Line::Reply(0)));
  ASSERT_EQ(to.asked.size(), 2U) << "for the third one";
  EXPECT_EQ(to.line.Close(), 2U);
}

TEST(ReplyLine, DropsTheReplyOfACancelledCall) {
  const auto room = std::make_shared<ServiceRoom>();
  Line to(room);
  EXPECT_TRUE(to.line.Send(Line::Reply(7)));
  EXPECT_FALSE(to.line.Withdraw(8));
  EXPECT_TRUE(to.line.Withdraw(7));
  EXPECT_FALSE(to.line.Withdraw(7));
  EXPECT_EQ(room->reply_bytes, 0U);
  EXPECT_EQ(to.line.Close(), 0U);
}

// Small messages fit, large ones find no memory.
class TightOutlet final : public KeepingOutlet {
 public:
  // `late`: the lack shows only when the message is handed over.
  explicit TightOutlet(bool late) : late_(late) {}
  PublishStatus Reserve(const void* message, const TypeInfo&, PreparedMessage&) noexcept override {
    return late_ || Fits(message) ? PublishStatus::kOk : PublishStatus::kNoMemory;
  }
  bool Commit(const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
              PreparedMessage&& prepared) noexcept override {
    return Fits(message.get()) && KeepingOutlet::Commit(message, type, info, std::move(prepared));
  }

 private:
  static bool Fits(const void* message) noexcept { return !static_cast<const CallMessage*>(message)->body; }
  const bool late_;
};

class NoMemory : public testing::TestWithParam<bool> {};

TEST_P(NoMemory, ForAReplyIsARefusal) {
  const auto outlet = std::make_shared<TightOutlet>(GetParam());
  int soon = 0;
  ReplyLine line(outlet, CallTypeOf<Total>(), std::make_shared<Log>([](LogLevel, std::string_view) {}), "add", "arm",
                 std::make_shared<ServiceRoom>(), {[&] { ++soon; }, {}, {}});
  CallMessage reply;
  reply.call = 5;
  reply.body = std::make_shared<const Total>();
  EXPECT_TRUE(line.Send(std::make_shared<const CallMessage>(reply)));
  EXPECT_EQ(soon, 0);
  EXPECT_EQ(line.Close(), 0U);
  ASSERT_EQ(outlet->sent.size(), 1U);
  EXPECT_EQ(outlet->sent[0].call, 5U);
  EXPECT_EQ(outlet->sent[0].outcome, CallMessage::Outcome::kNotWritable);
  EXPECT_EQ(outlet->sent[0].text, "The reply could not be written: no memory.");
  EXPECT_EQ(outlet->sent[0].body, nullptr);
}

// A caller's place, from which one session is reached that serves every name. The test sends the replies.
class TestPlace final : public ServicePlace {
 public:
  explicit TestPlace(std::shared_ptr<SessionOutlet> to_server) : outlet_(std::move(to_server)) {}
  Subscription Listen(const std::string&, const TypeInfo&, AnyCallback callback, std::size_t) override {
    on_reply = std::move(callback);
    return {};
  }
  std::shared_ptr<SessionOutlet> OpenOutlet(const std::string&, const TypeInfo&, OutletEvents events) override {
    events_ = std::move(events);
    return outlet_;
  }
  void CloseOutlet(const std::string&, const std::shared_ptr<SessionOutlet>&) override {}
  [[nodiscard]] DataGraph& Graph() override { return graph_; }
  [[nodiscard]] ChannelSearch Search(const std::string&) override { return {}; }
  [[nodiscard]] std::vector<PeerInfo> Peers() const override { return {}; }
  [[nodiscard]] int LongestSilenceMs() const override { return 0; }
  [[nodiscard]] ReplyWays WaysOf(const std::string&) const override { return {.offered = 1}; }
  [[nodiscard]] std::vector<std::string> KnownServices() override { return {}; }
  void ReportServedTwice(const PeerInfo&, std::string, std::string) noexcept override {}
  void Receive(const Visit& visit) noexcept override { visit.first(); }

  AnyCallback on_reply;

 private:
  const std::shared_ptr<SessionOutlet> outlet_;
  DataGraph graph_;
  OutletEvents events_;
};

// The services of such a place.
struct TestServices {
  explicit TestServices(ServicePlace& place)
      : services(std::make_shared<hgros::Services>(place, SessionId{1},
                                                   std::make_shared<Log>([](LogLevel, std::string_view) {}))) {}
  ~TestServices() {
    services->Refuse();
    services->Close();
  }
  [[nodiscard]] auto CallAdd() const {
    return services->Call("add",
                          {CallTypeOf<Sum>(), CallTypeOf<Total>(), TypeOf<Sum>(), std::make_shared<const Sum>(),
                           std::chrono::seconds(20)},
                          {});
  }
  const std::shared_ptr<hgros::Services> services;
};

TEST_P(NoMemory, ForARequestEndsTheCall) {
  TestPlace place(std::make_shared<TightOutlet>(GetParam()));
  const TestServices services(place);
  for (int i = 0; i < 2; ++i) {  // The first one waits until the server is known. The second one is sent at once.
    const CallEnd end = services.CallAdd()->Wait();
    EXPECT_EQ(end.failure.kind, CallFailure::Kind::kNotWritable);
    EXPECT_EQ(end.failure.reason, "The request of service \"add\" could not be written: no memory.");
  }
}

// Commit() says false if only some of the transports had memory. Then the caller gets the reply and the refusal.
TEST(ReplyLine, RefusalAfterItsReplyIsIgnored) {
  const auto outlet = std::make_shared<KeepingOutlet>();
  TestPlace place(outlet);
  const TestServices services(place);
  const auto call = services.CallAdd();
  ASSERT_TRUE(Await([&] { return outlet->count == 1; }));
  CallMessage reply = outlet->sent[0];
  MessageInfo info;
  info.id.publisher = reply.server;
  info.remote = true;
  reply.body = std::make_shared<const Total>(Total{5});
  reply.type = &TypeOf<Total>();
  place.on_reply(std::make_shared<const CallMessage>(reply), info);
  reply.body = nullptr;
  reply.outcome = CallMessage::Outcome::kNotWritable;
  place.on_reply(std::make_shared<const CallMessage>(reply), info);
  const CallEnd end = call->Wait();
  ASSERT_NE(end.reply, nullptr) << end.failure.reason;
  EXPECT_EQ(static_cast<const Total*>(end.reply.get())->value, 5);
}

INSTANTIATE_TEST_SUITE_P(Shows, NoMemory, testing::Bool(),
                         [](const auto& late) { return late.param ? "WhenHandedOver" : "WhenReserved"; });

}  // namespace
}  // namespace hgros::test

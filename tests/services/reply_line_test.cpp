#include "services/reply_line.hpp"

#include <gtest/gtest.h>

#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/clock/host_clocks.hpp"
#include "hgros/internal/codec/call_message.hpp"
#include "hgros/services/service_place.hpp"
#include "hgros/services/services.hpp"
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

// A caller's subscription: small messages fit, large ones find no memory.
class TightOutlet final : public SessionOutlet {
 public:
  // `late`: the lack shows only when the message is handed over.
  explicit TightOutlet(bool late) : late_(late) {}
  [[nodiscard]] bool wanted() const noexcept override { return true; }
  PublishStatus Reserve(const void* message, const TypeInfo&, PreparedMessage&) noexcept override {
    return late_ || Fits(message) ? PublishStatus::kOk : PublishStatus::kNoMemory;
  }
  bool Commit(const AnyMessage& message, const TypeInfo&, const MessageInfo&, PreparedMessage&&) noexcept override {
    if (!Fits(message.get())) return false;
    sent.push_back(*static_cast<const CallMessage*>(message.get()));
    return true;
  }
  void Cancel() noexcept override {}
  [[nodiscard]] std::size_t subscriber_count() const noexcept override { return 1; }
  [[nodiscard]] std::vector<SessionId> Subscribers() const override { return {SessionId{2}}; }

  std::vector<CallMessage> sent;

 private:
  static bool Fits(const void* message) noexcept { return !static_cast<const CallMessage*>(message)->body; }
  const bool late_;
};

class NoMemory : public testing::TestWithParam<bool> {};

TEST_P(NoMemory, ForAReplyIsARefusal) {
  const auto outlet = std::make_shared<TightOutlet>(GetParam());
  int soon = 0;
  ReplyLine line(outlet, CallTypeOf<test::Total>(), std::make_shared<Log>([](LogLevel, std::string_view) {}), "add",
                 [&] { ++soon; });
  CallMessage reply;
  reply.call = 5;
  reply.body = std::make_shared<const test::Total>();
  EXPECT_TRUE(line.Send(std::make_shared<const CallMessage>(reply)));
  EXPECT_EQ(soon, 0);
  EXPECT_EQ(line.Close(), 0U);
  ASSERT_EQ(outlet->sent.size(), 1U);
  EXPECT_EQ(outlet->sent[0].call, 5U);
  EXPECT_EQ(outlet->sent[0].outcome, CallMessage::Outcome::kNotWritable);
  EXPECT_EQ(outlet->sent[0].text, "The reply could not be written: no memory.");
  EXPECT_EQ(outlet->sent[0].body, nullptr);
}

// One session that serves every name, reached through a TightOutlet.
class TightPlace final : public ServicePlace {
 public:
  explicit TightPlace(bool late) : late_(late) {}
  Subscription Listen(const std::string&, const TypeInfo&, AnyCallback, std::size_t) override { return {}; }
  std::shared_ptr<SessionOutlet> OpenOutlet(const std::string&, const TypeInfo&, OutletEvents events) override {
    events_ = std::move(events);
    return std::make_shared<TightOutlet>(late_);
  }
  void CloseOutlet(const std::string&, const std::shared_ptr<SessionOutlet>&) override {}
  [[nodiscard]] DataGraph& Graph() override { return graph_; }
  [[nodiscard]] ChannelSearch Search(const std::string&) override { return {}; }
  [[nodiscard]] std::vector<PeerInfo> Peers() const override { return {}; }
  [[nodiscard]] std::vector<std::string> KnownServices() override { return {}; }
  void ReportServedTwice(const PeerInfo&, std::string, std::string) noexcept override {}
  void Receive(const Visit& visit) noexcept override { visit.first(); }

 private:
  const bool late_;
  DataGraph graph_;
  OutletEvents events_;
};

TEST_P(NoMemory, ForARequestEndsTheCall) {
  TightPlace place(GetParam());
  const auto services =
      std::make_shared<Services>(place, SessionId{1}, std::make_shared<Log>([](LogLevel, std::string_view) {}));
  const auto call = [&] {
    return services->Call("add",
                          {CallTypeOf<test::Sum>(), CallTypeOf<test::Total>(), TypeOf<test::Sum>(),
                           std::make_shared<const test::Sum>(), std::chrono::seconds(20)},
                          {});
  };
  for (int i = 0; i < 2; ++i) {  // The first one waits until the server is known. The second one is sent at once.
    const CallEnd end = call()->Wait();
    EXPECT_EQ(end.failure.kind, CallFailure::Kind::kNotWritable);
    EXPECT_EQ(end.failure.reason, "The request of service \"add\" could not be written: no memory.");
  }
  services->Refuse();
  services->Close();
}

/// A caller's place. Its requests arrive, and the test sends the replies.
class OpenPlace final : public ServicePlace {
 public:
  struct TakingOutlet final : SessionOutlet {
    [[nodiscard]] bool wanted() const noexcept override { return true; }
    PublishStatus Reserve(const void*, const TypeInfo&, PreparedMessage&) noexcept override {
      return PublishStatus::kOk;
    }
    bool Commit(const AnyMessage& message, const TypeInfo&, const MessageInfo&, PreparedMessage&&) noexcept override {
      sent.push_back(*static_cast<const CallMessage*>(message.get()));
      ++count;
      return true;
    }
    void Cancel() noexcept override {}
    [[nodiscard]] std::size_t subscriber_count() const noexcept override { return 1; }
    [[nodiscard]] std::vector<SessionId> Subscribers() const override { return {SessionId{2}}; }
    std::vector<CallMessage> sent;  // Read after `count` says so.
    std::atomic<int> count{0};
  };
  Subscription Listen(const std::string&, const TypeInfo&, AnyCallback callback, std::size_t) override {
    on_reply = std::move(callback);
    return {};
  }
  std::shared_ptr<SessionOutlet> OpenOutlet(const std::string&, const TypeInfo&, OutletEvents) override {
    return outlet;
  }
  void CloseOutlet(const std::string&, const std::shared_ptr<SessionOutlet>&) override {}
  [[nodiscard]] DataGraph& Graph() override { return graph_; }
  [[nodiscard]] ChannelSearch Search(const std::string&) override { return {}; }
  [[nodiscard]] std::vector<PeerInfo> Peers() const override { return {}; }
  [[nodiscard]] std::vector<std::string> KnownServices() override { return {}; }
  void ReportServedTwice(const PeerInfo&, std::string, std::string) noexcept override {}
  void Receive(const Visit& visit) noexcept override { visit.first(); }

  const std::shared_ptr<TakingOutlet> outlet = std::make_shared<TakingOutlet>();
  AnyCallback on_reply;

 private:
  DataGraph graph_;
};

// Commit() says false if only some of the transports had memory. Then the caller gets the reply and the refusal.
TEST(ReplyLine, RefusalAfterItsReplyIsIgnored) {
  OpenPlace place;
  const auto services =
      std::make_shared<Services>(place, SessionId{1}, std::make_shared<Log>([](LogLevel, std::string_view) {}));
  const auto call = services->Call("add",
                                   {CallTypeOf<test::Sum>(), CallTypeOf<test::Total>(), TypeOf<test::Sum>(),
                                    std::make_shared<const test::Sum>(), std::chrono::seconds(20)},
                                   {});
  ASSERT_TRUE(test::Await([&] { return place.outlet->count == 1; }));
  CallMessage reply = place.outlet->sent[0];
  MessageInfo info;
  info.id.publisher = reply.server;
  info.remote = true;
  reply.body = std::make_shared<const test::Total>(test::Total{5});
  reply.type = &TypeOf<test::Total>();
  place.on_reply(std::make_shared<const CallMessage>(reply), info);
  reply.body = nullptr;
  reply.outcome = CallMessage::Outcome::kNotWritable;
  place.on_reply(std::make_shared<const CallMessage>(reply), info);
  const CallEnd end = call->Wait();
  ASSERT_NE(end.reply, nullptr) << end.failure.reason;
  EXPECT_EQ(static_cast<const test::Total*>(end.reply.get())->value, 5);
  services->Refuse();
  services->Close();
}

INSTANTIATE_TEST_SUITE_P(Shows, NoMemory, testing::Bool(),
                         [](const auto& late) { return late.param ? "WhenHandedOver" : "WhenReserved"; });

}  // namespace
}  // namespace hgros

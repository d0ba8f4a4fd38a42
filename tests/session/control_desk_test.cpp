// Requests to change a session, as the desk takes them from a transport.
#include "session/control/control_desk.hpp"

#include <gmock/gmock.h>

#include <new>
#include <string>
#include <utility>

#include "session/bare_bridge.hpp"

namespace hgros::test {
namespace {

using testing::ElementsAre;

constexpr SessionId kSelf{5};

class ControlDeskTest : public testing::Test {
 protected:
  ~ControlDeskTest() override { desk_.Close(); }

  void Ask(const std::string& channel, SessionId from, bool trusted) {
    ControlRequest request;
    request.set_version(kControlVersion);
    request.add_sessions(kSelf.value);
    request.set_number(++number_);
    request.set_action(ControlRequest::CLOSE);
    request.set_channel(channel);
    const auto bytes = std::make_shared<const std::string>(request.SerializeAsString());
    InboundMessage message;
    message.from = from;
    message.trusted = trusted;
    message.data = {AsBytes(*bytes), bytes};
    EXPECT_EQ(bridge_.sink().Accept(std::move(message)), Accepted::kNothing);
  }
  void RunErrands() {
    for (const auto& errand : std::exchange(errands_, {})) errand();
  }

  std::vector<std::string> obeyed_;  // The channels.
  bool has_memory_ = true;
  std::vector<std::function<void()>> errands_;
  std::uint64_t number_ = 0;
  BareBridge bridge_;
  ControlDesk desk_{*bridge_,
                    {.self = kSelf,
                     .log = std::make_shared<Log>([](LogLevel, std::string_view) {}),
                     .name_of = [](SessionId id) { return id.ToString(); },
                     .obey =
                         [this](const ControlRequest& request, ControlReply& reply) {
                           obeyed_.push_back(request.channel());
                           reply.set_done("Done.");
                         },
                     .open_replies = [] { return nullptr; },
                     .post =
                         [this](std::function<void()> errand) {
                           if (!has_memory_) throw std::bad_alloc();
                           errands_.push_back(std::move(errand));
                         }}};
};

TEST_F(ControlDeskTest, TakesTheOwnersRequestWhileStrangersAskWithoutEnd) {
  for (int i = 0; i < 200; ++i) Ask("strange", SessionId{7}, false);
  Ask("own", SessionId{6}, true);
  RunErrands();
  EXPECT_THAT(obeyed_, ElementsAre("own"));
  EXPECT_EQ(desk_.refused(), 200U);
}

TEST_F(ControlDeskTest, IsNotBehindAfterAnErrandThatCouldNotBePosted) {
  has_memory_ = false;
  for (int i = 0; i < 100; ++i) Ask("lost", SessionId{6}, true);
  has_memory_ = true;
  Ask("posted", SessionId{6}, true);
  RunErrands();
  EXPECT_THAT(obeyed_, ElementsAre("posted"));
}

}  // namespace
}  // namespace hgros::test

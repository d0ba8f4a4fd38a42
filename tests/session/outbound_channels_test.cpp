#include "session/outbound_channels.hpp"

#include <gtest/gtest.h>

#include <new>
#include <utility>

#include "hgros/codec/raw_message.hpp"
#include "session/bare_bridge.hpp"

namespace hgros::test {
namespace {

class OutboundChannelsTest : public testing::Test {
 protected:
  OutboundChannelsTest() { channels_.Join(*bridge_); }
  ~OutboundChannelsTest() override {
    channels_.Close();
    channels_.Detach();
  }

  static OutletEvents NoEvents() {
    return {[] {}, [] {}, [] { return true; }};
  }
  std::shared_ptr<ChannelOutlet> Open(const std::string& channel) {
    return channels_.Open(
        channel, AnyType(), [] { return NoEvents(); }, [](const auto&) {});
  }
  /// Whether a message stays inside the session. It is accepted, and never finished.
  bool Stays(ChannelOutlet& outlet) {
    PreparedMessage prepared;
    EXPECT_EQ(outlet.Reserve(message_.get(), AnyType(), prepared), PublishStatus::kOk);
    return prepared.state == PreparedMessage::State::kStays;
  }
  void Forbid(bool forbidden) { channels_.SetForbidden("notes", forbidden, later_); }
  void RunFirstErrand() {
    const auto errand = std::move(errands_.front());
    errands_.erase(errands_.begin());
    errand();
  }

  const AnyMessage message_ = std::make_shared<const RawMessage>(RawMessage{nullptr, Block::Allocate(8).payload()});
  bool has_memory_ = true;
  std::vector<std::function<void()>> errands_;
  const OutboundChannels::Later later_ = [this](std::chrono::nanoseconds, std::function<void()> errand) {
    if (!has_memory_) throw std::bad_alloc();
    errands_.push_back(std::move(errand));
  };
  BareBridge bridge_;
  OutboundChannels channels_{MessageId{1, 1, 0}, std::make_shared<Log>([](LogLevel, std::string_view) {}),
                             std::make_shared<HostClocks>()};
};

TEST_F(OutboundChannelsTest, EarlierForbidDoesNotWithdrawForALaterOne) {
  const auto outlet = Open("notes");
  EXPECT_FALSE(Stays(*outlet));  // Unfinished: the channel is not withdrawn yet.
  Forbid(true);
  Forbid(false);
  Forbid(true);
  ASSERT_EQ(errands_.size(), 2U);
  RunFirstErrand();
  EXPECT_EQ(errands_.size(), 1U) << "the first forbid goes on";
  RunFirstErrand();
  EXPECT_EQ(errands_.size(), 1U) << "the second forbid does not wait";
}

TEST_F(OutboundChannelsTest, ChannelIsNotHalfForbiddenIfThereIsNoMemory) {
  const auto outlet = Open("notes");
  EXPECT_FALSE(Stays(*outlet));
  has_memory_ = false;
  EXPECT_THROW(Forbid(true), std::bad_alloc);
  EXPECT_FALSE(Stays(*outlet));
  has_memory_ = true;
  Forbid(true);
  EXPECT_TRUE(Stays(*outlet));
  EXPECT_EQ(errands_.size(), 1U);
}

TEST_F(OutboundChannelsTest, ForbiddenChannelIsWithdrawnAtOnceIfItCannotBePutOff) {
  const auto outlet = Open("notes");
  EXPECT_FALSE(Stays(*outlet));
  Forbid(true);
  EXPECT_TRUE(outlet->HasUnfinished());
  has_memory_ = false;
  while (!errands_.empty()) RunFirstErrand();
  EXPECT_FALSE(outlet->HasUnfinished());
}

TEST_F(OutboundChannelsTest, OutletThatIsOpenedAfterTheEndReachesNobody) {
  channels_.Close();
  const auto outlet = channels_.OpenForService("hgros/reply/ask", AnyType(), NoEvents());
  ASSERT_NE(outlet, nullptr);
  EXPECT_FALSE(Stays(*outlet));
  EXPECT_FALSE(outlet->HasUnfinished()) << "it has joined a transport";
  std::vector<ChannelUse> uses;
  channels_.AddTo(uses);
  EXPECT_TRUE(uses.empty());
}

}  // namespace
}  // namespace hgros::test

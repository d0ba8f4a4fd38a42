// A publisher in a memory control group that is too small for its shared memory.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "resilience/shm_numbers.hpp"
#include "resilience/small_group.hpp"
#include "resilience/worker_process.hpp"
#include "support/await.hpp"

namespace hgros::resilience {
namespace {

using test::Await;

constexpr std::uint64_t kGroupBytes = 48u << 20;
constexpr auto kSameLineAgainAfter = std::chrono::seconds(10);  // The same as in Log::WriteLimited.

/// Keeps all messages.
class Hoard : public InboundSink {
 public:
  Accepted Accept(InboundMessage&& message) noexcept override {
    const std::scoped_lock lock(mutex_);
    ++count_;
    held_.push_back(std::move(message));
    return Accepted::kNothing;
  }
  void Run() noexcept override {}
  void OnFault(PacketFault, std::string_view) noexcept override {}
  void OnPublishers(std::size_t) noexcept override {}
  [[nodiscard]] std::uint64_t count() const {
    const std::scoped_lock lock(mutex_);
    return count_;
  }
  void LetGo() {
    const std::scoped_lock lock(mutex_);
    held_.clear();
  }

 private:
  mutable std::mutex mutex_;
  std::uint64_t count_ = 0;
  std::vector<InboundMessage> held_;
};

TEST(ShmMemoryGroupProcess, AFullGroupKillsNoProcessAndMessagesGoOverTheSocket) {
  const SmallGroup group(kGroupBytes);
  if (!group.why_not.empty()) GTEST_SKIP() << group.why_not;
  QuietListener listener;
  Log log{[](LogLevel, std::string_view) {}};
  ShmOptions options = NumberOptions("hub");
  options.place = "hgros-test-" + SessionId::Random().ToString();
  const auto hub = MakeShmTransport(options, listener, log);
  NumberStream down(*hub, "down", 100);
  Hoard hoard;
  // Not lossless: otherwise the publisher would keep unconfirmed messages, including those that went over the socket.
  const auto up =
      hub->Subscribe("up", NumberType(), {.credit_messages = 512, .credit_bytes = std::uint64_t{1} << 30}, hoard);
  WorkerProcess worker({options.place, group.folder});
  // All messages together need more memory than the group may have.
  constexpr std::uint64_t kMessages = 2 * kGroupBytes / 500'000;
  std::uint64_t published = 0;
  const auto publish = [&](std::uint64_t until) {
    while (published < until) {
      ASSERT_TRUE(down.PublishNext({}));
      ++published;
      ASSERT_TRUE(Await([&] { return hoard.count() == published; })) << published << worker;
      ASSERT_TRUE(worker.alive()) << worker;
    }
    ASSERT_TRUE(worker.Reaches({{"published", until}})) << worker;
  };
  const auto begin = std::chrono::steady_clock::now();
  publish(kMessages);
  // On a busy machine this may take longer than the time for which the log suppresses the same line.
  const auto lines = 1 + static_cast<std::uint64_t>((std::chrono::steady_clock::now() - begin) / kSameLineAgainAfter);
  EXPECT_GT(worker["apart"], kMessages / 4) << worker;
  EXPECT_LT(worker["apart"], kMessages) << worker;
  EXPECT_GE(worker["warnings"], 1u) << worker;
  EXPECT_LE(worker["warnings"], lines) << "logged once, not for each message" << worker;
  // Released blocks are used again from the second message on: the publisher notices them with the first one.
  hoard.LetGo();
  publish(kMessages + 1);
  const std::uint64_t apart = worker["apart"];
  publish(kMessages + 11);
  EXPECT_EQ(worker["apart"], apart) << worker;
  EXPECT_EQ(worker.Finish(), 0) << worker;
}

}  // namespace
}  // namespace hgros::resilience

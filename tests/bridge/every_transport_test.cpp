// One program that runs by pointer, through shared memory, over ipc and over tcp, depending only on its configuration.
#include <sys/mman.h>

#include <optional>

#include "session/domain_fixture.hpp"

namespace hgros::test {
namespace {

// The program: a wheel that counts, and an odometer that adds.
constexpr int kTurns = 200;

void Turn(Session& session) {
  const auto publish = session.Advertise<Note>("wheel");
  ASSERT_TRUE(session.WaitForSubscribers("wheel", 1, kPatience));
  for (int turn = 1; turn <= kTurns; ++turn) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    ASSERT_EQ(publish.Wait(std::make_unique<Note>(std::to_string(turn)), deadline), PublishStatus::kOk);
  }
}

class Odometer {
 public:
  explicit Odometer(Session& session)
      : subscription_(session.FromAny<Note>("wheel", Invoke::kSerial,
                                            [this](const Note& turn) {
                                              in_order_ = in_order_ && std::stoi(turn.text) == turns_ + 1;
                                              ++turns_;
                                            },
                                            {.queue = Queue::KeepAll(16)})) {}
  [[nodiscard]] bool HasAll() const {
    return Await([this] { return turns_ == kTurns; }) && in_order_;
  }

 private:
  std::atomic<int> turns_{0};
  std::atomic<bool> in_order_{true};
  Subscription subscription_;
};

// The configurations of its parts.
struct Placement {
  std::string name;
  std::string wheel;
  /// The odometer's configuration, made once the wheel's session exists. Empty: it runs in that session.
  std::function<std::optional<std::string>(Session& wheel)> odometer;
  std::string transport;
};

std::string SubscribingAt(const Session& session) {
  return "network: {subscribers: [{ip: \"" + session.PublisherEndpoints().at(0) + "\"}]}\ndiscovery: {local: false}";
}

const Bus& TheBus() {
  static const Bus bus;
  return bus;
}

class EveryTransport : public DomainFixture, public testing::WithParamInterface<Placement> {
 protected:
  EveryTransport() {
    if (const auto yaml = placement.odometer(*first.session)) second.emplace(*yaml);
  }
  const Placement& placement = GetParam();
  Robot first{placement.wheel};
  std::optional<Robot> second;
};

TEST_P(EveryTransport, RunsTheSameProgram) {
  Note::written = 0;
  {
    const Odometer odometer(second ? *second->session : *first.session);
    Turn(*first.session);
    EXPECT_TRUE(odometer.HasAll());
    const auto peers = first->Peers();
    EXPECT_EQ(peers.empty() ? "pointer" : peers.at(0).transport, placement.transport);
    EXPECT_EQ(Note::written, second ? kTurns : 0) << "encoded once for each message that leaves the process";
    if (placement.name == "ipc" || placement.name == "tcp") {
      EXPECT_EQ(second->session->Peers().at(0).endpoint.substr(0, 3), placement.name);
    }
  }
}

// Addresses without memory: nothing may read or write them.
class AddressRange {
 public:
  explicit AddressRange(std::size_t size_bytes)
      : size_(size_bytes),
        begin_(mmap(nullptr, size_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)) {}
  AddressRange(const AddressRange&) = delete;
  AddressRange& operator=(const AddressRange&) = delete;
  ~AddressRange() { munmap(begin_, size_); }
  [[nodiscard]] std::unique_ptr<Block> block() const {
    return std::make_unique<Block>(Payload{{static_cast<const std::byte*>(begin_), size_}, not_owned_});
  }

 private:
  const std::size_t size_;
  void* const begin_;
  const std::shared_ptr<const int> not_owned_ = std::make_shared<const int>(0);
};

TEST_P(EveryTransport, RefusesAMessageAboveTheLimitAndKeepsThePeer) {
  const AddressRange range(kMaxMessageBytes + 1);
  Session& there = second ? *second->session : *first.session;
  std::atomic<std::size_t> got{0};
  std::atomic<std::uint64_t> last_size{0};
  const auto count = [&](const Block& block) {
    last_size = block.size();
    ++got;
  };
  const auto subscription = there.FromAny<Block>("wheel", Invoke::kSerial, count, {.queue = Queue::KeepAll(4)});
  const auto newest =
      there.FromAny<Block>("newest", Invoke::kSerial, [](const Block&) {}, {.queue = Queue::KeepLast(1)});
  const auto publish = first->Advertise<Block>("wheel");
  const auto publish_newest = first->Advertise<Block>("newest");
  ASSERT_TRUE(first->WaitForSubscribers("wheel", 1, kPatience));
  ASSERT_TRUE(first->WaitForSubscribers("newest", 1, kPatience));
  auto large = range.block();
  if (second) {
    EXPECT_EQ(publish(std::move(large)), PublishStatus::kTooLarge);
    EXPECT_EQ(publish.Wait(std::move(large), std::chrono::steady_clock::now() + kPatience), PublishStatus::kTooLarge);
    EXPECT_EQ(publish_newest(std::move(large)), PublishStatus::kTooLarge) << "of a subscriber that keeps the newest";
    ASSERT_NE(large, nullptr) << "the caller still owns it";
  } else {
    EXPECT_EQ(publish(std::move(large)), PublishStatus::kOk) << "inside a session any size is possible";
    ASSERT_TRUE(Await([&] { return got == 1; }));
    EXPECT_EQ(last_size, kMaxMessageBytes + 1);
    got = 0;
  }
  ASSERT_EQ(publish(std::make_unique<Block>(Block::Allocate(100))), PublishStatus::kOk);
  ASSERT_TRUE(Await([&] { return got == 1; }));
  EXPECT_EQ(last_size, 100U);
  EXPECT_FALSE(first.Said("is gone"));
  EXPECT_EQ(first->Peers().size(), second ? 1U : 0U);
}

INSTANTIATE_TEST_SUITE_P(
    Placed, EveryTransport,
    testing::Values(Placement{"pointer", "", [](Session&) { return std::nullopt; }, "pointer"},
                    Placement{"sharedmemory", "", [](Session&) { return std::optional<std::string>(""); },
                              "shared memory"},
                    Placement{"ipc", TheBus().Publishing("wheel"),
                              [](Session& wheel) { return std::optional(SubscribingAt(wheel)); }, "ZeroMQ"},
                    Placement{"tcp", "network: {publisher: {ip: 'tcp://127.0.0.1:*'}}",
                              [](Session& wheel) { return std::optional(SubscribingAt(wheel)); }, "ZeroMQ"}),
    [](const auto& placed) { return placed.param.name; });

}  // namespace
}  // namespace hgros::test

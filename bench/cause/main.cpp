// What the cause of a message costs: in ns for each message inside a process while nobody looks, and in bytes on the
// wire. The steps that were added to the way of a message run alone in a loop.
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "graph/channel/message_numbers.hpp"
#include "graph/nodes/live_chain_ages.hpp"
#include "hgros/internal/codec/packet.hpp"
#include "support/samples.hpp"

namespace hgros::bench {
namespace {

constexpr int kRounds = 200;
constexpr int kMessages = 20'000;

// The least time of one step, as others use the machine, too.
template <class Step>
double LeastNs(Step step) {
  double least = std::numeric_limits<double>::max();
  for (int round = 0; round < kRounds; ++round) {
    const std::int64_t begin = MonotonicNow();
    for (int i = 0; i < kMessages; ++i) step(i);
    least = std::min(least, static_cast<double>(MonotonicNow() - begin) / kMessages);
  }
  return least;
}

// Keeps the compiler from leaving out what has no effect.
template <class T>
void Use(const T& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

// Of a message that a callback publishes, in a chain of a quarter of a second, after some that were not sent.
double BytesOfACause() {
  PacketHead head;
  head.channel = "robot1/scan";
  head.id = {0xfedcba9876543210, 1'700'000'000'000'000'001, 300};
  std::string frame;
  EncodeHeadFrame(head, frame);
  const std::size_t without = frame.size();
  head.cause = {0x123456789abcdef0, 250'000'000, Cause::OriginOf("robot1/camera"), 100};
  EncodeHeadFrame(head, frame);
  return static_cast<double>(frame.size() - without);
}

int Run() {
  const MessageId publisher{7, 8, 0};
  MessageNumbers numbers("scan", publisher);
  LiveChainAges ages;
  std::atomic<std::uint64_t> last{0};
  // Number, publisher and time were there before.
  const double before = LeastNs([&](int) {
    MessageInfo info;
    info.id = publisher;
    info.publish_monotonic_ns = MonotonicNow();
    info.id.sequence = last.fetch_add(1, std::memory_order_relaxed) + 1;
    Use(info);
  });
  const double now = LeastNs([&](int i) {
    MessageInfo info = numbers.NewInfo(publisher);
    numbers.Number(info);
    Use(info);
    const CauseScope scope({info.key, info.cause.began_ns, info.cause.origin});
    ages.Record(info.cause.origin, i, Writers::kOne);
    Use(scope);
  });
  Report("cause_ns", now - before, "ns");
  Report("cause_bytes", BytesOfACause(), "bytes");
  return 0;
}

}  // namespace
}  // namespace hgros::bench

int main() { return hgros::bench::Run(); }

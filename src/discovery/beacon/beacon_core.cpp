#include "discovery/beacon/beacon_core.hpp"

#include <pthread.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "discovery/beacon/datagram.hpp"
#include "hgros/base/error.hpp"
#include "hgros/base/system_limits.hpp"

namespace hgros::discovery {
namespace {

// Minimum time between two datagrams that we send.
constexpr auto kLeastPause = std::chrono::milliseconds(20);
// Longest random delay of an answer, so that a hundred peers that hear a new one do not answer at the same time.
constexpr int kLongestAnswerMs = 100;
// Datagrams beyond this rate are left to the kernel, which drops them: a flood cannot keep this thread busy. Rejecting
// a datagram costs little, so that it counts as a tenth: garbage seldom displaces the others.
constexpr int kDatagramsPerSecond = 2000;
constexpr int kCostOfDatagram = 10;
constexpr int kCostOfGarbage = 1;
constexpr int kBudgetPerSecond = kDatagramsPerSecond * kCostOfDatagram;
// Once the budget is used up, reading continues after this time. The kernel keeps about 250 datagrams until then.
constexpr auto kRefill = std::chrono::milliseconds(10);

}  // namespace

BeaconCore::BeaconCore(const BeaconOptions& options, DiscoveryListener& listener, Log& log)
    : options_(options),
      listener_(listener),
      log_(log),
      socket_(options.interfaces, options.port),
      peers_(book_, options.patience),
      random_(static_cast<std::minstd_rand::result_type>(RandomId())) {
  RequireDomain(options_.domain);
  if (options_.period < kLeastPause || options_.patience <= options_.period) {
    throw Error("A beacon cannot have a period of " + std::to_string(options_.period.count()) +
                    " ms and a patience of " + std::to_string(options_.patience.count()) + " ms.",
                {}, "Use a period of at least 20 ms, and several times as much patience.");
  }
  thread_ = StartThread<std::thread>("the thread of the beacon", [this] { Loop(); });
}

BeaconCore::~BeaconCore() {
  stopping_ = true;
  wake_.Signal();
  thread_.join();
  if (own_) (void)socket_.Send(EncodeDatagram(*own_, options_.domain, true));
}

void BeaconCore::Announce(const Announcement& own) {
  std::string datagram = EncodeDatagram(own, options_.domain, false);
  (void)EncodeDatagram(own, options_.domain, true);  // Its goodbye fits, too.
  {
    const std::scoped_lock lock(mutex_);
    if (own_ && own_->session != own.session) {
      throw Error("A beacon that announces session " + own_->session.ToString() + " cannot announce " +
                      own.session.ToString() + " too.",
                  {}, "Open a beacon for each session.");
    }
    const bool first = !own_;
    own_ = own;
    if (!first && datagram == datagram_) return;
    datagram_ = std::move(datagram);
    next_send_ = std::max(Clock::now(), last_sent_ + kLeastPause);
    if (first) Send(datagram_);
  }
  wake_.Signal();
}

void BeaconCore::Loop() {
  pthread_setname_np(pthread_self(), "hgros-beacon");
  for (;;) {
    book_.Tell(listener_);
    wake_.Wait(budget_ > 0 ? socket_.fd() : -1, Deadline());
    if (stopping_) return;
    const Clock::time_point now = Clock::now();
    RefillBudget(now);
    if (now >= next_refresh_) {
      RefreshInterfaces();
      next_refresh_ = now + options_.period;
    }
    HearAll();
    peers_.Expire(Clock::now());
    SendIfDue();
  }
}

void BeaconCore::RefreshInterfaces() {
  for (std::string& fault : socket_.Refresh()) {
    const auto [sentence, is_new] = said_.insert(std::move(fault));
    if (is_new) log_.Write(LogLevel::kWarning, *sentence);
  }
}

void BeaconCore::RefillBudget(Clock::time_point now) {
  const auto added = std::min<Clock::duration>(now - refilled_, std::chrono::seconds(1)) * kBudgetPerSecond;
  const auto whole = std::chrono::floor<std::chrono::seconds>(added).count();
  if (whole == 0) return;
  budget_ = std::min(budget_ + static_cast<int>(whole), kBudgetPerSecond);
  refilled_ = now;
}

BeaconCore::Clock::time_point BeaconCore::Deadline() const {
  Clock::time_point first = next_refresh_;
  if (const auto expiry = peers_.next_expiry()) first = std::min(first, *expiry);
  if (budget_ <= 0) first = std::min(first, refilled_ + kRefill);
  const std::scoped_lock lock(mutex_);
  return own_ ? std::min(first, next_send_) : first;
}

void BeaconCore::HearAll() {
  std::array<std::byte, kMaxDatagramBytes> buffer;
  while (budget_ > 0) {
    const auto datagram = socket_.Receive(buffer);
    if (!datagram) return;
    const std::string sender = AddressText(datagram->sender);
    const auto heard = ParseDatagram(datagram->bytes, options_.domain, sender);
    budget_ -= heard ? kCostOfDatagram : kCostOfGarbage;
    if (!heard) continue;
    {
      const std::scoped_lock lock(mutex_);
      if (own_ && own_->session == heard->peer.session) continue;
    }
    const auto verdict = peers_.Hear(*heard, sender, Clock::now());
    if (verdict == BeaconPeers::Verdict::kNew) Answer();
    if (verdict == BeaconPeers::Verdict::kTooMany) {
      log_.WriteLimited(LogLevel::kWarning, "beacon peers",
                        "More than " + std::to_string(BeaconPeers::kMaxPeers) +
                            " sessions are heard by the beacon; the rest are ignored. Give the robots of this network "
                            "domains of their own, or find the sender that floods it.");
    }
  }
  log_.WriteLimited(LogLevel::kWarning, "beacon rate",
                    "More than " + std::to_string(kDatagramsPerSecond) +
                        " datagrams a second reach the beacon, or more than " + std::to_string(kBudgetPerSecond) +
                        " that are not of this domain; the rest are dropped. Find the sender that floods UDP port " +
                        std::to_string(options_.port) + ".");
}

void BeaconCore::Answer() {
  const std::chrono::milliseconds delay(std::uniform_int_distribution<int>(0, kLongestAnswerMs)(random_));
  const std::scoped_lock lock(mutex_);
  next_send_ = std::min(next_send_, std::max(Clock::now() + delay, last_sent_ + kLeastPause));
}

void BeaconCore::SendIfDue() {
  const std::scoped_lock lock(mutex_);
  if (own_ && next_send_ <= Clock::now()) Send(datagram_);
}

void BeaconCore::Send(const std::string& datagram) {
  const std::string fault = socket_.Send(datagram);
  last_sent_ = Clock::now();
  next_send_ = last_sent_ + options_.period;
  if (fault.empty()) return;
  log_.WriteLimited(LogLevel::kWarning, "beacon send",
                    "The beacon cannot send on an interface (" + fault +
                        "). It tries again; to exclude this interface, name the others in its options.",
                    std::chrono::minutes(1));
}

}  // namespace hgros::discovery

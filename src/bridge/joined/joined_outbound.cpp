#include "bridge/joined/joined_outbound.hpp"

#include <algorithm>
#include <new>
#include <numeric>
#include <string_view>
#include <utility>

#include "hgros/clock/time.hpp"

namespace hgros {
namespace {

constexpr std::string_view kLibraryPrefix = "hgros/";
constexpr std::int64_t kFlowsWithinNs = 1'000'000'000;

}  // namespace

// The publishing side, as one transport sees it.
class JoinedOutbound::Part final : public OutboundSource {
 public:
  Part(JoinedOutbound& joined, std::size_t index) : joined_(joined), index_(index) {}

  std::vector<OutboundMessage> Latched(SessionId subscriber) noexcept override { return joined_.First(subscriber); }
  bool OnCut(SessionId subscriber, const Demand& demand, std::vector<OutboundMessage>&& unfinished) noexcept override {
    joined_.Keep(subscriber, demand, std::move(unfinished));
    return true;
  }
  [[nodiscard]] bool may_promise() const noexcept override { return joined_.source_.may_promise(); }
  void OnRoom() noexcept override { joined_.source_.OnRoom(); }
  void OnSubscribers(std::size_t count) noexcept override {
    {
      const std::scoped_lock lock(joined_.telling_);
      joined_.subscribers_[index_] = count;
    }
    joined_.TellSubscribers();
  }
  void OnUnsubscribed(SessionId subscriber) noexcept override {
    joined_.gate_.Through([&] {
      if (joined_.HasEnded(subscriber, index_)) joined_.source_.OnUnsubscribed(subscriber);
    });
  }

  std::unique_ptr<OutboundChannel> channel;

 private:
  JoinedOutbound& joined_;
  const std::size_t index_;
};

JoinedOutbound::JoinedOutbound(std::string channel, const TypeInfo& type, OutboundSource& source,
                               std::size_t most_transports, Await await, Log& log)
    : channel_(std::move(channel)),
      type_(type),
      source_(source),
      await_(std::move(await)),
      log_(log),
      parts_(most_transports),
      subscribers_(most_transports) {}

JoinedOutbound::~JoinedOutbound() { Close(); }

// Whoever has found it in the bridge's list may still hold it.
void JoinedOutbound::Close() {
  {
    const std::scoped_lock lock(adding_);
    no_more_parts_ = true;
  }
  gate_.Close();
  // Each part's channel waits for the active calls into the source.
  for (const auto& part : parts_) {
    if (part) part->channel.reset();
  }
}

void JoinedOutbound::Add(Transport& transport) {
  const std::scoped_lock lock(adding_);
  if (no_more_parts_) return;
  const std::size_t index = count_.load();
  parts_.at(index) = std::make_unique<Part>(*this, index);
  parts_[index]->channel = transport.Advertise(channel_, type_, *parts_[index]);
  count_.store(index + 1, std::memory_order_release);
}

void JoinedOutbound::TellSubscribers() {
  const std::scoped_lock lock(telling_);
  source_.OnSubscribers(std::accumulate(subscribers_.begin(), subscribers_.end(), cut_.count()));
}

void JoinedOutbound::Keep(SessionId subscriber, const Demand& demand, std::vector<OutboundMessage>&& unfinished) {
  const std::uint64_t cut = cut_.Add(subscriber, demand, std::move(unfinished));
  await_(subscriber, [weak = weak_from_this(), subscriber, cut](const std::string& name) {
    if (const auto joined = weak.lock()) joined->GiveUp(subscriber, name, cut);
  });
}

std::vector<OutboundMessage> JoinedOutbound::First(SessionId subscriber) {
  std::vector<OutboundMessage> messages = source_.Latched(subscriber);
  if (cut_.count() == 0) return messages;
  {
    // A message that is being committed must be among them, or come over the new link.
    const std::scoped_lock lock(committing_);
    for (OutboundMessage& message : cut_.TakeMessages(subscriber)) messages.push_back(std::move(message));
  }
  const auto number = [](const OutboundMessage& message) { return message.head.id.sequence; };
  std::ranges::sort(messages, {}, number);
  const auto same = [&](const OutboundMessage& a, const OutboundMessage& b) { return number(a) == number(b); };
  messages.erase(std::unique(messages.begin(), messages.end(), same), messages.end());
  TellSubscribers();
  if (refused_.exchange(false)) source_.OnRoom();
  return messages;
}

void JoinedOutbound::GiveUp(SessionId subscriber, const std::string& name, std::optional<std::uint64_t> cut) {
  std::optional<CutSubscribers::Messages> missed;  // Destroyed outside the gate.
  gate_.Through([&] {
    bool flows = false;
    {
      const std::scoped_lock lock(committing_);
      missed = cut_.Drop(subscriber, cut);
      flows = last_ns_ > MonotonicNow() - kFlowsWithinNs && !channel_.starts_with(kLibraryPrefix);
    }
    if (!missed) return;
    missed_.fetch_add(missed->size(), std::memory_order_relaxed);
    if (!missed->empty()) {
      log_.WriteLimited(LogLevel::kWarning, "missed " + channel_,
                        "Session " + name + " has gone without confirming " + std::to_string(missed->size()) +
                            " messages of the lossless channel \"" + channel_ +
                            "\". It may miss these, and misses those that are published until it is back.");
    } else if (flows) {
      log_.WriteLimited(LogLevel::kWarning, "missed " + channel_,
                        "Session " + name + " has gone. It misses the messages of the lossless channel \"" + channel_ +
                            "\" that are published until it is back.");
    }
    TellSubscribers();
    if (refused_.exchange(false)) source_.OnRoom();
  });
}

std::size_t JoinedOutbound::subscriber_count() const noexcept {
  std::size_t sum = cut_.count();
  for (const auto& part : Parts()) sum += part->channel->subscriber_count();
  return sum;
}

std::vector<SessionId> JoinedOutbound::Subscribers() const {
  std::vector<SessionId> all;
  for (const auto& part : Parts()) {
    for (const SessionId one : part->channel->Subscribers()) {
      if (std::ranges::find(all, one) == all.end()) all.push_back(one);
    }
  }
  return all;
}

// A subscriber that moves stays on the other transports. One that ends over all may begin again over some meanwhile.
bool JoinedOutbound::HasEnded(SessionId subscriber, std::size_t part) {
  std::set<std::size_t> there;
  for (std::size_t i = 0; i < Parts().size(); ++i) {
    if (i != part && std::ranges::count(parts_[i]->channel->Subscribers(), subscriber) > 0) there.insert(i);
  }
  std::vector<SessionId> live = Subscribers();  // Others were lost.
  live.push_back(subscriber);
  const std::scoped_lock lock(telling_);
  std::erase_if(ending_, [&](const auto& one) { return std::ranges::find(live, one.first) == live.end(); });
  const auto left = ending_.try_emplace(subscriber, there).first;
  std::erase_if(left->second, [&](std::size_t one) { return !there.contains(one); });
  if (!left->second.empty()) return false;
  ending_.erase(left);
  return true;
}

PublishStatus JoinedOutbound::Reserve() noexcept {
  if (cut_.count() > 0 && !cut_.HasRoom()) {
    refused_ = true;
    if (!cut_.HasRoom()) return PublishStatus::kFull;
  }
  const auto parts = Parts();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const PublishStatus status = parts[i]->channel->Reserve();
    if (status == PublishStatus::kOk) continue;
    for (const auto& before : parts.first(i)) before->channel->Cancel();
    return status;
  }
  return PublishStatus::kOk;
}

bool JoinedOutbound::Commit(const PacketHead& head, const Payload& data) noexcept {
  bool all = true;
  {
    const std::scoped_lock lock(committing_);
    last_ns_ = head.publish_monotonic_ns;
    for (const auto& part : Parts()) all = part->channel->Commit(head, data) && all;
    if (cut_.count() > 0) {  // Last, for subscribers that are cut off meanwhile.
      const std::size_t missed = cut_.Push(head, data);
      missed_.fetch_add(missed, std::memory_order_relaxed);
      all = all && missed == 0;
    }
  }
  if (!all) SayNoMemory();
  return all;
}

void JoinedOutbound::SayNoMemory() noexcept {
  try {
    log_.WriteLimited(LogLevel::kError, "commit " + channel_,
                      "There was no memory to hand a message on channel \"" + channel_ +
                          "\" to all of its subscribers in other sessions: some miss it. Publish smaller messages, or "
                          "raise the memory limit of the process or of its control group.");
  } catch (const std::bad_alloc&) {  // It is said with a later message.
  }
}

void JoinedOutbound::Cancel() noexcept {
  for (const auto& part : Parts()) part->channel->Cancel();
}

template <typename Holds>
bool JoinedOutbound::AnyListened(const Holds& holds) const {
  return std::ranges::any_of(
      Parts(), [&](const auto& part) { return part->channel->subscriber_count() > 0 && holds(*part->channel); });
}

std::optional<Block> JoinedOutbound::Loan(std::size_t size_bytes) {
  std::optional<Block> loan;
  (void)AnyListened([&](OutboundChannel& channel) { return (loan = channel.Loan(size_bytes)).has_value(); });
  return loan;
}

bool JoinedOutbound::FindMemory(std::size_t size_bytes, Bytes written, std::optional<Block>& loan) {
  const auto holds = [&](const OutboundChannel& channel) { return channel.Holds(written); };
  const auto lacks = [&](const OutboundChannel& channel) {
    return !channel.HasMemoryFor(size_bytes, !written.empty());
  };
  if (!written.empty() && AnyListened(holds)) return true;
  return AnyListened([&](OutboundChannel& channel) { return (loan = channel.Loan(size_bytes)).has_value(); }) ||
         !AnyListened(lacks);
}

OutboundStats JoinedOutbound::stats() const {
  OutboundStats sum;
  for (const auto& part : Parts()) {
    const auto stats = part->channel->stats();
    sum.subscribers += stats.subscribers;
    sum.sent += stats.sent;
    sum.dropped += stats.dropped;
    sum.missed += stats.missed;
    sum.queued_bytes += stats.queued_bytes;
    sum.copied += stats.copied;
  }
  sum.subscribers += cut_.count();
  sum.missed += missed_.load(std::memory_order_relaxed);
  return sum;
}

std::size_t JoinedOutbound::Unfinished() const {
  std::size_t sum = 0;
  for (const auto& part : Parts()) sum += part->channel->Unfinished();
  return sum;
}

}  // namespace hgros

#include "session/channel_inlet.hpp"

#include <algorithm>
#include <utility>

#include "hgros/clock/time.hpp"
#include "hgros/graph/helping.hpp"
#include "session/service_place.hpp"

namespace hgros {
namespace {

// Decoding more than this is left to a thread that owns no socket.
constexpr std::size_t kQuickBytes = 64 * 1024;
// A peer could invent publishers; those heard longest ago are forgotten first.
constexpr std::size_t kMaxPublishers = 4096;
constexpr int kMessagesPerErrand = 16;

}  // namespace

ChannelInlet::ChannelInlet(Channel& channel, const TypeInfo& type, std::shared_ptr<Log> log,
                           std::function<void()> on_publishers, std::function<void(Errand)> run_apart,
                           std::shared_ptr<const HostClocks> clocks)
    : channel_(channel),
      type_(type),
      brings_replies_(IsReplyChannel(DataGraph::NameOf(channel))),
      log_(std::move(log)),
      on_publishers_(std::move(on_publishers)),
      run_apart_(std::move(run_apart)),
      clocks_(std::move(clocks)) {}

void ChannelInlet::Join(Carriers& carriers, const Demand& demand) {
  lossless_.store(demand.lossless, std::memory_order_relaxed);
  auto carrier = carriers.Subscribe(DataGraph::NameOf(channel_), type_, demand, *this);
  const std::scoped_lock lock(carrier_mutex_);
  carrier_ = std::move(carrier);
}

void ChannelInlet::Detach() {
  std::shared_ptr<JoinedInbound> carrier;
  {
    const std::scoped_lock lock(carrier_mutex_);
    carrier = std::move(carrier_);
  }
  carrier.reset();
  // No thread of the carrier is inside any more, and a Run() that was asked for may not have been made; an errand is.
  Fifo<InboundMessage> left;  // Let go of after the lock, for the credits.
  std::optional<Decoded> undelivered;
  {
    const std::scoped_lock lock(waiting_mutex_);
    std::swap(left, waiting_);
    undelivered.swap(handed_over_);
    if (runner_ != Runner::kErrand) runner_ = Runner::kNobody;
  }
  publishers_.store(0, std::memory_order_release);
  // What is published while nobody here wants it is not lost.
  const std::scoped_lock lock(counts_mutex_);
  for (auto& [publisher, life] : lives_) life.away = true;
}

void ChannelInlet::SetDemand(const Demand& demand) {
  lossless_.store(demand.lossless, std::memory_order_relaxed);
  const std::scoped_lock lock(carrier_mutex_);
  if (carrier_) carrier_->SetDemand(demand);
}

bool ChannelInlet::IsQuick(const InboundMessage& message) const noexcept {
  return message.data.bytes.size() <= kQuickBytes && !type_.users_codec;
}

Accepted ChannelInlet::Accept(InboundMessage&& message) noexcept {
  const ThreadUse use = DataGraph::UseOfThread(channel_);
  const bool quick = IsQuick(message);
  Runner runner = use == ThreadUse::kHelp ? Runner::kCarrierHelps : Runner::kCarrierApart;
  if (quick && use == ThreadUse::kNone) runner = Runner::kCarrier;
  if (quick && brings_replies_ && ShmTransport::IsVisitor()) runner = Runner::kVisitor;
  const std::scoped_lock lock(waiting_mutex_);
  waiting_.Put(std::move(message));
  if (runner_ != Runner::kNobody) return Accepted::kNothing;
  runner_ = runner;
  return runner == Runner::kCarrier || runner == Runner::kVisitor ? Accepted::kRunHere : Accepted::kRunApart;
}

ChannelInlet::Taken ChannelInlet::Take(InboundMessage& message, UserCode user_code) {
  const std::scoped_lock lock(waiting_mutex_);
  if (waiting_.empty()) {
    runner_ = Runner::kNobody;
    return Taken::kNone;
  }
  if (user_code == UserCode::kRefused && !IsQuick(waiting_.front())) return Taken::kNotQuick;
  message = waiting_.Take();
  return Taken::kMessage;
}

void ChannelInlet::Run() noexcept {
  Runner as = Runner::kNobody;
  {
    const std::scoped_lock lock(waiting_mutex_);
    as = runner_;
  }
  const UserCode decoding = as == Runner::kCarrier || as == Runner::kVisitor ? UserCode::kRefused : UserCode::kAllowed;
  const UserCode injecting = as == Runner::kCarrier ? UserCode::kRefused : UserCode::kAllowed;
  // Last of all, when the next message finds nobody running: a long callback holds up no other node of the channel.
  Helping helping(as == Runner::kCarrierHelps);
  std::optional<Decoded> undelivered;
  while (!undelivered) {
    InboundMessage message;
    const Taken taken = Take(message, decoding);
    // A visitor reads for others too: what a reply has made ready is user code, which is the workers'.
    if (taken == Taken::kNone) return as == Runner::kVisitor ? helping.PassOn() : helping.Run();
    helping.PassOn();
    if (taken == Taken::kNotQuick) break;
    std::optional<Decoded> decoded = Decode(std::move(message));
    if (decoded && !Inject(*decoded, injecting)) undelivered = std::move(decoded);
  }
  {
    const std::scoped_lock lock(waiting_mutex_);
    runner_ = Runner::kErrand;
    handed_over_ = std::move(undelivered);
  }
  run_apart_([this] { RunErrand(); });
}

// A few at a time, so that other errands have their turn.
void ChannelInlet::RunErrand() noexcept {
  std::optional<Decoded> first;
  {
    const std::scoped_lock lock(waiting_mutex_);
    first = std::exchange(handed_over_, std::nullopt);
  }
  if (first) (void)Inject(*first, UserCode::kAllowed);
  for (int i = 0; i < kMessagesPerErrand; ++i) {
    InboundMessage message;
    if (Take(message, UserCode::kAllowed) == Taken::kNone) return;
    if (const auto decoded = Decode(std::move(message))) (void)Inject(*decoded, UserCode::kAllowed);
  }
  run_apart_([this] { RunErrand(); });
}

bool ChannelInlet::CountIn(const InboundMessage& message, std::uint64_t& lost) {
  const MessageId& id = message.head.id;
  const std::scoped_lock lock(counts_mutex_);
  if (const std::int64_t then = message.head.publish_time_ns; then > 0) {
    transport_.Record(clocks_->Since(then, message.from).count());
  }
  const std::pair who{message.from.value, id.publisher};
  if (lives_.size() >= kMaxPublishers && !lives_.contains(who)) {
    lives_.erase(std::min_element(lives_.begin(), lives_.end(), [](const auto& a, const auto& b) {
      return a.second.last_heard_ns < b.second.last_heard_ns;
    }));
  }
  Life& life = lives_[who];
  life.last_heard_ns = MonotonicNow();
  life.traffic.publisher = SessionId{id.publisher};
  if (id.publisher == 0) {  // It does not count; so neither gaps nor repeats can be told.
    ++life.traffic.received;
    return true;
  }
  const bool known = life.incarnation == id.incarnation;
  if ((known && id.sequence <= life.last_sequence) || id.incarnation < life.incarnation) {
    ++life.traffic.repeated;
    return false;
  }
  if (known && !life.away && id.sequence > life.last_sequence + 1) {
    lost = id.sequence - life.last_sequence - 1;
    life.traffic.lost += lost;
  }
  life.away = false;
  life.incarnation = id.incarnation;
  life.last_sequence = id.sequence;
  ++life.traffic.received;
  return true;
}

std::optional<ChannelInlet::Decoded> ChannelInlet::Decode(InboundMessage&& message) noexcept {
  const PacketHead& head = message.head;
  if (!head.type_name.empty() && head.type_name != type_.name) {
    OnFault(PacketFault::kType,
            "it carries " + head.type_name + ", but the channel is used with " + type_.name +
                " here; build both programs with one type, or give one of them another channel name");
    return std::nullopt;
  }
  std::uint64_t lost = 0;
  if (!CountIn(message, lost)) return std::nullopt;
  if (lost > 0 && lossless_.load(std::memory_order_relaxed)) SayLost(lost);
  Decoded decoded;
  decoded.type = &DataGraph::InboundType(channel_);
  decoded.message = decoded.type->decode(message.data);
  if (decoded.message == nullptr) {
    OnFault(PacketFault::kData, "its data does not parse as " + type_.name);
    return std::nullopt;
  }
  decoded.info.id = head.id;
  decoded.info.publish_monotonic_ns = MonotonicNow();
  decoded.info.publish_time_ns = head.publish_time_ns;
  decoded.credit = std::move(message.credit);
  decoded.latched = head.latched;
  return decoded;
}

bool ChannelInlet::Inject(const Decoded& decoded, UserCode user_code) noexcept {
  return DataGraph::Inject(channel_, decoded.message, *decoded.type, decoded.info, decoded.credit, decoded.latched,
                           user_code);
}

// Keep-last subscribers expect it and find it counted; a lossless one was away for too long.
void ChannelInlet::SayLost(std::uint64_t count) {
  const std::string& name = DataGraph::NameOf(channel_);
  log_->WriteLimited(LogLevel::kWarning, "inlet lost " + name,
                     std::to_string(count) + " messages of the lossless channel \"" + name +
                         "\" did not arrive: their publisher could not reach this process for longer than the peer "
                         "timeout.");
}

void ChannelInlet::OnFault(PacketFault fault, std::string_view what) noexcept {
  {
    const std::scoped_lock lock(counts_mutex_);
    ++faults_[static_cast<std::size_t>(fault)];
  }
  const std::string& name = DataGraph::NameOf(channel_);
  log_->WriteLimited(LogLevel::kWarning, "inlet " + name + " " + std::string(ToString(fault)),
                     "A packet on channel \"" + name + "\" was dropped: " + std::string(what) + ".");
}

void ChannelInlet::OnPublishers(std::size_t count) noexcept {
  publishers_.store(count, std::memory_order_release);
  on_publishers_();
}

void ChannelInlet::AddTo(ChannelTraffic& traffic) const {
  traffic.publishers = publisher_count();
  const std::scoped_lock lock(counts_mutex_);
  for (const auto& [publisher, life] : lives_) traffic.in.push_back(life.traffic);
  traffic.faults = faults_;
  traffic.transport.Merge(transport_);
}

}  // namespace hgros

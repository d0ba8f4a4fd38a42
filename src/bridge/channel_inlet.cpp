#include "hgros/bridge/channel_inlet.hpp"

#include <algorithm>
#include <utility>

#include "bridge/joined/joined_inbound.hpp"
#include "hgros/base/message_key.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/codec/protobuf_log.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/graph/delivered_credit.hpp"
#include "hgros/graph/ready_node_slot.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {
namespace {

// Messages above this size are decoded on a thread that owns no socket.
constexpr std::size_t kQuickBytes = 64 * 1024;
// A limit against peers that invent publishers. Publishers that were silent for longest are forgotten first.
constexpr std::size_t kMaxPublishers = 4096;
constexpr int kMessagesAtOnce = 16;
constexpr std::string_view kOfTheLibrary = "hgros/";
// A limit against plain publishers that name a new type in each message.
constexpr std::size_t kMostSaidSchemas = 32;
// Chains older than a day count as a day old.
constexpr std::int64_t kMostAgeNs = 24 * 3600 * std::int64_t{1'000'000'000};

}  // namespace

ChannelInlet::ChannelInlet(Channel& channel, bool brings_replies, std::shared_ptr<Log> log,
                           std::function<void()> on_publishers, std::function<void(Errand)> run_apart,
                           TellMisfit tell_misfit, std::shared_ptr<const HostClocks> clocks)
    : channel_(channel),
      type_(&DataGraph::TypeOfChannel(channel)),
      brings_replies_(brings_replies),
      is_librarys_(DataGraph::NameOf(channel).starts_with(kOfTheLibrary)),
      log_(std::move(log)),
      on_publishers_(std::move(on_publishers)),
      run_apart_(std::move(run_apart)),
      tell_misfit_(std::move(tell_misfit)),
      origin_(Cause::OriginOf(DataGraph::NameOf(channel))),
      clocks_(std::move(clocks)) {
  [[maybe_unused]] static const bool limited = (LimitProtobufLog(), true);
}

void ChannelInlet::Join(NetworkBridge& bridge, const Demand& demand) {
  lossless_.store(demand.lossless, std::memory_order_relaxed);
  const TypeInfo& type = TypeToAsk();
  type_.store(&type, std::memory_order_release);
  auto joined = bridge.Subscribe(DataGraph::NameOf(channel_), type, DataGraph::TypeOfChannel(channel_), demand, *this);
  const std::scoped_lock lock(transports_mutex_);
  transports_ = std::move(joined);
}

// A type that stays inside this process has no name outside, so a subscription with it accepts any type. The type of
// bytes that this session itself publishes does not matter either.
const TypeInfo& ChannelInlet::TypeToAsk() const noexcept {
  const TypeInfo& own = DataGraph::TypeOfChannel(channel_);
  return own.encoding == Encoding::kNone || IsRunTimeType(own) ? AnyType() : own;
}

Fifo<InboundMessage> ChannelInlet::Leave() {
  Fifo<InboundMessage> left;
  {
    const std::scoped_lock lock(waiting_mutex_);
    leaves_ = true;
    std::swap(left, waiting_);
    taken_ += left.size();
    detached_.fetch_add(1, std::memory_order_release);
  }
  if (DataGraph::ForgetRemoteLatched(channel_)) {
    const std::scoped_lock lock(counts_mutex_);
    for (auto& [publisher, life] : lives_) life.StartOver();
  }
  return left;
}

void ChannelInlet::Detach() {
  std::shared_ptr<JoinedInbound> transports;
  {
    const std::scoped_lock lock(transports_mutex_);
    transports = std::move(transports_);
  }
  if (transports) transports->Close();
  // No thread of the transport or the bridge is inside any more. A requested Run() may not have been called, but a
  // requested errand is.
  Fifo<InboundMessage> left;  // Destroyed after the lock, because this returns credit.
  std::optional<Decoded> undelivered;
  {
    const std::scoped_lock lock(waiting_mutex_);
    std::swap(left, waiting_);
    taken_ += left.size();
    undelivered.swap(handed_over_);
    if (runner_ != Runner::kErrand) runner_ = Runner::kNobody;
    leaves_ = false;
    detached_.fetch_add(1, std::memory_order_release);  // An errand may have taken a message before.
  }
  publishers_.store(0, std::memory_order_release);
  ForgetOffers();
  // Messages that are published while there is no subscriber here do not count as lost.
  const std::scoped_lock lock(counts_mutex_);
  for (auto& [publisher, life] : lives_) life.NoteAway();
}

bool ChannelInlet::busy() { return (std::scoped_lock(transports_mutex_), transports_ && transports_->busy()); }

void ChannelInlet::End() {
  const std::scoped_lock lock(transports_mutex_);
  if (transports_) transports_->End();
}

void ChannelInlet::SetDemand(const Demand& demand) {
  lossless_.store(demand.lossless, std::memory_order_relaxed);
  const std::scoped_lock lock(transports_mutex_);
  if (transports_) transports_->SetDemand(demand);
}

bool ChannelInlet::IsQuick(const InboundMessage& message) const noexcept {
  return message.data.bytes.size() <= kQuickBytes && !type_.load(std::memory_order_relaxed)->users_codec;
}

Accepted ChannelInlet::Accept(InboundMessage&& message) noexcept {
  const ThreadUse use = DataGraph::UseOfThread(channel_);
  const bool quick = IsQuick(message);
  // A visitor runs no callbacks of the workers.
  const bool helps = use == ThreadUse::kRunNode && !Transport::IsVisitor();
  Runner runner = helps ? Runner::kTransportHelps : Runner::kTransportApart;
  if (quick && use == ThreadUse::kNone) runner = Runner::kTransport;
  if (quick && brings_replies_ && Transport::IsVisitor()) runner = Runner::kVisitor;
  const std::scoped_lock lock(waiting_mutex_);
  if (leaves_) return Accepted::kNothing;
  waiting_.Put(std::move(message));
  if (runner_ != Runner::kNobody) return Accepted::kNothing;
  runner_ = runner;
  return runner == Runner::kTransport || runner == Runner::kVisitor ? Accepted::kRunHere : Accepted::kRunApart;
}

ChannelInlet::Taken ChannelInlet::TakeNext(InboundMessage& message, UserCode user_code, Turn& turn) {
  const std::scoped_lock lock(waiting_mutex_);
  if (waiting_.empty()) {
    runner_ = Runner::kNobody;
    return Taken::kNone;
  }
  if (user_code == UserCode::kRefused && !IsQuick(waiting_.front())) return Taken::kNotQuick;
  message = waiting_.Take();
  turn = {detached_.load(std::memory_order_relaxed), ++taken_};
  return Taken::kMessage;
}

void ChannelInlet::Run() noexcept {
  Runner as = Runner::kNobody;
  {
    const std::scoped_lock lock(waiting_mutex_);
    as = runner_;
  }
  const UserCode decoding =
      as == Runner::kTransport || as == Runner::kVisitor ? UserCode::kRefused : UserCode::kAllowed;
  const UserCode injecting = as == Runner::kTransport ? UserCode::kRefused : UserCode::kAllowed;
  // The slot's node runs last, when the next message finds no thread running. So a long callback does not block other
  // nodes of the channel.
  ReadyNodeSlot slot(as == Runner::kTransportHelps);
  std::optional<Decoded> undelivered;
  for (int i = 0; !undelivered; ++i) {
    if (i >= kMessagesAtOnce && Transport::IsVisitor() && HasWaiting()) break;
    if (i == kMessagesAtOnce && HasWaiting() && Transport::LeaveRest()) return;
    InboundMessage message;
    Turn turn;
    const Taken taken = TakeNext(message, decoding, turn);
    // A visitor also reads for others. A node that a reply has made ready is user code, so the workers run it.
    if (taken == Taken::kNone) return as == Runner::kVisitor ? slot.HandToWorkers() : slot.RunKept();
    slot.HandToWorkers();
    if (taken == Taken::kNotQuick) break;
    std::optional<Decoded> decoded = Decode(std::move(message), turn);
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
  for (int i = 0; i < kMessagesAtOnce; ++i) {
    InboundMessage message;
    Turn turn;
    if (TakeNext(message, UserCode::kAllowed, turn) == Taken::kNone) return;
    if (const auto decoded = Decode(std::move(message), turn)) (void)Inject(*decoded, UserCode::kAllowed);
  }
  run_apart_([this] { RunErrand(); });
}

bool ChannelInlet::CountIn(const InboundMessage& message, const Turn& turn, PublisherLife::Gap& lost,
                           std::int64_t& way_ns) {
  const std::scoped_lock lock(counts_mutex_);
  if (detached_.load(std::memory_order_acquire) != turn.detached) return false;
  std::optional<std::int64_t> published_ns;
  if (const std::int64_t then = message.head.publish_time_ns; then > 0) {
    way_ns = clocks_->Since(then, message.from).count();
    transport_.Record(way_ns);
    published_ns = MonotonicNow() - way_ns;
  }
  const std::pair who{message.from.value, message.head.id.publisher};
  if (lives_.size() >= kMaxPublishers && !lives_.contains(who)) {
    lives_.erase(std::min_element(lives_.begin(), lives_.end(), [](const auto& a, const auto& b) {
      return a.second.last_heard_ns() < b.second.last_heard_ns();
    }));
  }
  return lives_[who].Count(message.head.id, turn.number, published_ns, lost);
}

std::optional<ChannelInlet::Decoded> ChannelInlet::Decode(InboundMessage&& message, const Turn& turn) noexcept {
  const PacketHead& head = message.head;
  if (is_librarys_ && (message.from.value == 0 || head.id.publisher != message.from.value)) {
    OnFault(PacketFault::kHead, "its head names a publisher that has not sent it");
    return std::nullopt;
  }
  const bool any = TakesAny();
  const TypeInfo& asked = *type_.load(std::memory_order_relaxed);
  if (!any && !head.type_name.empty() && head.type_name != asked.name) {
    OnFault(PacketFault::kType,
            "it carries " + head.type_name + ", but the channel is used with " + asked.name +
                " here; build both programs with one type, or give one of them another channel name");
    return std::nullopt;
  }
  PublisherLife::Gap lost;
  std::int64_t way_ns = 0;
  if (!CountIn(message, turn, lost, way_ns)) return std::nullopt;
  if (lost.messages > 0 && lossless_.load(std::memory_order_relaxed)) SayLost(lost, message.from);
  Decoded decoded;
  decoded.type = any ? &AnyType() : &DataGraph::InboundType(channel_);
  if (IsAnyType(*decoded.type)) {
    decoded.message = std::make_shared<const RawMessage>(RawMessage{SchemaOf(message), std::move(message.data)});
  } else {
    decoded.message = decoded.type->decode(message.data);
  }
  if (decoded.message == nullptr) {
    OnFault(PacketFault::kData, "its data does not parse as " + asked.name);
    return std::nullopt;
  }
  decoded.info = InfoOf(message, way_ns);
  decoded.credit = std::move(message.credit);
  decoded.latched = head.latched;
  decoded.detached = turn.detached;
  return decoded;
}

// The sender may write any cause. Its numbers only name things, and the age is limited.
MessageInfo ChannelInlet::InfoOf(const InboundMessage& message, std::int64_t way_ns) const noexcept {
  const PacketHead& head = message.head;
  MessageInfo info;
  info.id = head.id;
  info.publish_monotonic_ns = MonotonicNow();
  info.publish_time_ns = head.publish_time_ns;
  const std::uint64_t age = std::min<std::uint64_t>(head.cause.chain_age_ns, kMostAgeNs) +
                            static_cast<std::uint64_t>(std::clamp<std::int64_t>(way_ns, 0, kMostAgeNs));
  info.cause.message = head.cause.message;
  info.cause.began_ns = info.publish_monotonic_ns - static_cast<std::int64_t>(std::min<std::uint64_t>(age, kMostAgeNs));
  info.cause.origin = head.cause.chain_origin == 0 ? origin_ : head.cause.chain_origin;
  const bool counts = head.id.publisher != 0;
  if (counts) info.number = head.id.sequence + static_cast<std::uint64_t>(head.cause.unsent);
  // A sender that does not count its messages: the time tells them apart.
  const std::uint64_t number = counts ? info.number : static_cast<std::uint64_t>(info.publish_monotonic_ns);
  info.key = MessageKey(KeySeed(head.id.publisher, head.id.incarnation, origin_), number);
  return info;
}

// Plain programs name the type in each message. Sessions with our own type send no schema.
std::shared_ptr<const MessageSchema> ChannelInlet::SchemaOf(const InboundMessage& message) {
  if (message.schema) return message.schema;
  const PacketHead& head = message.head;
  MessageSchema said{head.type_name, head.encoding, head.fingerprint, {}};
  const TypeInfo& asked = *type_.load(std::memory_order_relaxed);
  if (!IsAnyType(asked)) {
    if (said.fingerprint == 0) said.fingerprint = asked.fingerprint;
    said.type_name = asked.name;
    said.encoding = asked.encoding;
  }
  const auto known = std::ranges::find_if(said_schemas_, [&](const auto& one) {
    return one->type_name == said.type_name && one->encoding == said.encoding && one->fingerprint == said.fingerprint;
  });
  if (known != said_schemas_.end()) return *known;
  if (!IsAnyType(asked) && said.fingerprint == asked.fingerprint) said = hgros::SchemaOf(asked);
  if (said_schemas_.size() >= kMostSaidSchemas) said_schemas_.erase(said_schemas_.begin());
  return said_schemas_.emplace_back(std::make_shared<const MessageSchema>(std::move(said)));
}

void ChannelInlet::OnOffer(const PeerInfo& from, const std::shared_ptr<const MessageSchema>& schema) noexcept {
  {
    const std::scoped_lock lock(offers_mutex_);
    if (offers_.size() >= kMaxPublishers && !offers_.contains(from.id.value)) offers_.erase(offers_.begin());
    offers_[from.id.value] = {from, schema, false, ++last_offer_};
  }
  on_publishers_();  // A thread may wait for the schema.
  if (!IsAnyType(DataGraph::TypeOfChannel(channel_))) run_apart_([this] { CompareOffers(); });
}

void ChannelInlet::OnOfferEnded(SessionId from, OfferEnd why) noexcept {
  std::uint64_t accepted = 0;
  {
    const std::scoped_lock lock(waiting_mutex_);
    accepted = taken_ + waiting_.size();
  }
  {
    const std::scoped_lock lock(counts_mutex_);
    const auto first = lives_.lower_bound({from.value, 0});
    for (auto life = first; life != lives_.end() && life->first.first == from.value; ++life) {
      life->second.NoteEnd(why, accepted);
    }
  }
  Offer ended;  // Destroyed after the lock.
  const std::scoped_lock lock(offers_mutex_);
  if (const auto found = offers_.find(from.value); found != offers_.end()) {
    ended = std::move(found->second);
    offers_.erase(found);
  }
}

// Not on a transport's thread, because comparing schemas takes long.
void ChannelInlet::CompareOffers() {
  const TypeInfo& type = DataGraph::TypeOfChannel(channel_);
  if (IsAnyType(type)) return;
  const std::string& name = DataGraph::NameOf(channel_);
  std::vector<Offer> misfits;
  {
    const std::scoped_lock lock(offers_mutex_);
    for (auto& [session, offer] : offers_) {
      if (!std::exchange(offer.compared, true)) misfits.push_back(offer);
    }
  }
  for (const Offer& offer : misfits) {
    if (const std::string what = MisfitOf(*offer.schema, type); !what.empty()) {
      const std::string& theirs = offer.schema->type_name;
      const std::string both = " publishes " + theirs + ", this session subscribes to " + type.name;
      tell_misfit_(name, offer.from, name + ": " + offer.from.name() + both + (theirs == type.name ? ": " + what : ""));
    }
  }
}

std::shared_ptr<const MessageSchema> ChannelInlet::Schema() const {
  const std::scoped_lock lock(offers_mutex_);
  const auto newest = std::ranges::max_element(offers_, {}, [](const auto& offer) { return offer.second.number; });
  return newest == offers_.end() ? nullptr : newest->second.schema;
}

bool ChannelInlet::Inject(const Decoded& decoded, UserCode user_code) noexcept {
  if (detached_.load(std::memory_order_acquire) != decoded.detached) return true;
  const DeliveredCredit here(decoded.credit);
  return DataGraph::Inject(channel_, decoded.message, *decoded.type, decoded.info, decoded.credit, decoded.latched,
                           user_code);
}

// Keep-last subscribers expect losses and find them counted. A lossless subscriber loses messages if it was cut off for
// too long, or if their publisher had no memory to send them or found them too large. Only the publisher knows which.
void ChannelInlet::SayLost(const PublisherLife::Gap& lost, SessionId from) {
  const std::string& name = DataGraph::NameOf(channel_);
  log_->WriteLimited(LogLevel::kWarning, "inlet lost " + name,
                     std::to_string(lost.messages) + " messages of the lossless channel \"" + name +
                         "\" did not arrive: " +
                         (from.value == 0 ? "their publisher is a plain program, which does not wait for subscribers."
                          : lost.cut ? "the connection to their publisher was lost, and they were published before "
                                       "it was back."
                                     : "their publisher was connected, but could not send them. Its log says why."));
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
  if (count == 0) ForgetOffers();
  publishers_.store(count, std::memory_order_release);
  on_publishers_();
}

void ChannelInlet::AddTo(ChannelTraffic& traffic) const {
  traffic.publishers = publisher_count();
  const std::scoped_lock lock(counts_mutex_);
  for (const auto& [publisher, life] : lives_) traffic.in.push_back(life.traffic());
  traffic.faults = faults_;
  traffic.transport.Merge(transport_);
}

}  // namespace hgros

#include "graph/channel/channel.hpp"

#include <algorithm>
#include <utility>

#include "graph/channel/epoch.hpp"
#include "graph/graph_core.hpp"
#include "graph/nodes/callback_scope.hpp"
#include "hgros/base/thread_local.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/codec/run_time_type.hpp"

namespace hgros {

Channel::Channel(std::string name, const TypeInfo& type, std::string declared_at, GraphCore& core)
    : name_(std::move(name)),
      type_(&type),
      declared_at_(std::move(declared_at)),
      core_(core),
      numbers_(name_, core.publisher()),
      current_fanout_(std::make_shared<const Fanout>()) {
  fanout_.store(current_fanout_.get(), std::memory_order_seq_cst);
}

Channel::~Channel() {
  if (current_outlet_) epoch::Retire(std::move(current_outlet_));
  epoch::Retire(std::move(current_fanout_));
}

PublishStatus Channel::Publish(const MessageOffer& offer, Reach reach) noexcept {
  const PublishStatus status = Try(offer, reach);
  if (status != PublishStatus::kOk) counts_.refused.fetch_add(1, std::memory_order_relaxed);
  return status;
}

// Marks this thread as delivering local messages of a channel and running their callbacks itself. Messages that those
// callbacks publish on the same channel wait here, so that all nodes and sessions get the messages in the order of
// publishing.
class Channel::Handover {
 public:
  explicit Handover(const Channel& channel) noexcept : channel_(channel), outer_(std::exchange(innermost, this)) {}
  Handover(const Handover&) = delete;
  Handover& operator=(const Handover&) = delete;
  ~Handover() { innermost = outer_; }

  // The Handover of `channel` on this thread, or null.
  static Handover* Of(const Channel& channel) noexcept {
    Handover* one = innermost;
    while (one != nullptr && &one->channel_ != &channel) one = one->outer_;
    return one;
  }

  std::vector<Publication> waiting;

 private:
  static inline HGROS_THREAD_LOCAL Handover* innermost = nullptr;

  const Channel& channel_;
  Handover* const outer_;
};

PublishStatus Channel::Try(const MessageOffer& offer, Reach reach) noexcept {
  return wrapping_.load(std::memory_order_acquire) != 0 ? TryOneOfSeveral(offer, reach) : TryAs(offer, type(), reach);
}

PublishStatus Channel::TryAs(const MessageOffer& offer, const TypeInfo& type, Reach reach) noexcept {
  if (offer.message == nullptr) return PublishStatus::kEmpty;
  if (core_.refusing()) return PublishStatus::kClosed;
  const epoch::Guard guard;
  const Fanout& fanout = *fanout_.load(std::memory_order_seq_cst);
  const bool local = !closed_.load(std::memory_order_relaxed);
  Outlet* outlet = reach == Reach::kAny ? outlet_.load(std::memory_order_seq_cst) : nullptr;
  if (outlet != nullptr && !outlet->wanted()) outlet = nullptr;

  const std::size_t bytes = fanout.count_bytes ? type.memory_bytes(offer.message) : 0;
  const bool reserved = local && fanout.lossless;
  Handover* const outer = Handover::Of(*this);
  if (reserved && outer == nullptr && outlet == nullptr && fanout.sole_lossless != nullptr &&
      (fanout.nodes.size() == 1 || !fanout.has_inline) && latched_.load(std::memory_order_relaxed) == 0) {
    return PublishToSole(fanout, offer, bytes);
  }
  if (reserved && !ReserveAll(fanout, bytes)) return PublishStatus::kFull;
  PreparedMessage prepared;
  if (outlet != nullptr) {
    if (const PublishStatus status = outlet->Reserve(offer.message, type, prepared); status != PublishStatus::kOk) {
      if (reserved && CancelReservations(fanout, fanout.nodes.size(), bytes)) NotifyRoom();
      return status;
    }
  }

  Publication publication{offer.take(offer.context),
                          &type,
                          numbers_.NewInfo(core_.publisher()),
                          &fanout,
                          &fanout,
                          outlet,
                          bytes,
                          reserved,
                          local,
                          std::move(prepared)};
  MessageInfo& info = publication.info;
  if (const std::size_t depth = latched_.load(std::memory_order_relaxed); depth > 0 && local) {
    publication.after = Store(publication.message, info, depth, 0, UserCode::kAllowed);
  } else {
    numbers_.Number(info);
  }
  rate_.Note(info.id.sequence, info.publish_monotonic_ns);
  if (core_.trace().on()) [[unlikely]]
    Trace(info);
  if (outer != nullptr) {
    outer->waiting.push_back(std::move(publication));
  } else if (local && (fanout.has_inline || publication.after->has_inline)) {
    Handover handover(*this);
    HandOver(publication, info.publish_monotonic_ns);
    while (!handover.waiting.empty()) {
      for (Publication& next : std::exchange(handover.waiting, {})) HandOver(next, MonotonicNow());
    }
  } else {
    HandOver(publication, info.publish_monotonic_ns);
  }
  return PublishStatus::kOk;
}

namespace {

void DeliverToNewcomers(const Fanout& before, const Fanout& after, AnyMessage& message, const MessageInfo& info,
                        std::size_t bytes) noexcept {
  std::int64_t now = MonotonicNow();
  const std::shared_ptr<const void> no_credit;
  for (const std::shared_ptr<Node>& node : after.nodes) {
    if (std::find(before.nodes.begin(), before.nodes.end(), node) != before.nodes.end()) continue;
    node->Deliver({message, info, no_credit, bytes, false}, false, now);
  }
}

}  // namespace

void Channel::HandOver(Publication& publication, std::int64_t now) noexcept {
  auto& [message, type, info, fanout, after, outlet, bytes, reserved, local, prepared] = publication;
  if (local) {
    Deliver(*fanout, publication.message, info, nullptr,
            {bytes, reserved, outlet == nullptr && after == fanout, nullptr, now});
    if (after != fanout) DeliverToNewcomers(*fanout, *after, publication.message, info, bytes);
  }
  if (outlet != nullptr) (void)outlet->Commit(message, *type, info, std::move(prepared));
}

void Channel::Trace(const MessageInfo& info) const noexcept {
  const Node* const node = CallbackScope::NodeOf(&core_);
  core_.trace().AddPublish(name_, node == nullptr ? std::string_view() : node->setting().name, info);
}

// With only one lossless node no reservation has to be undone, so room and message are taken in one step.
PublishStatus Channel::PublishToSole(const Fanout& fanout, const MessageOffer& offer, std::size_t bytes) noexcept {
  AnyMessage message;
  MessageInfo info = numbers_.NewInfo(core_.publisher());
  std::int64_t now = info.publish_monotonic_ns;
  const bool alone = fanout.nodes.size() == 1;
  if (!fanout.sole_lossless->TryDeliverSole({offer, numbers_, bytes, alone}, message, info, now)) {
    return PublishStatus::kFull;
  }
  rate_.Note(info.id.sequence, info.publish_monotonic_ns);
  if (core_.trace().on()) [[unlikely]]
    Trace(info);
  if (!alone) Deliver(fanout, message, info, nullptr, {bytes, false, true, fanout.sole_lossless, now});
  return PublishStatus::kOk;
}

bool Channel::ReserveAll(const Fanout& fanout, std::size_t bytes) noexcept {
  for (std::size_t i = 0; i < fanout.nodes.size(); ++i) {
    if (!fanout.nodes[i]->lossless() || fanout.nodes[i]->Reserve(bytes)) continue;
    if (CancelReservations(fanout, i, bytes)) NotifyRoom();
    return false;
  }
  return true;
}

void Channel::Deliver(const Fanout& fanout, AnyMessage& message, const MessageInfo& info,
                      const std::shared_ptr<const void>& credit, const Handing& handing) noexcept {
  std::int64_t now = handing.now;
  for (const std::shared_ptr<Node>& node : fanout.nodes) {
    if (node.get() == handing.except) continue;
    const bool last = handing.last && &node == &fanout.nodes.back();
    node->Deliver({message, info, credit, handing.bytes, last}, handing.reserved && node->lossless(), now);
  }
}

const Fanout* Channel::Store(const AnyMessage& message, MessageInfo& info, std::size_t depth, std::size_t bytes,
                             UserCode user_code) {
  LatchedMessages::Stored stored;  // Destroyed after the lock: a message's destructor is user code.
  const Fanout* fanout = nullptr;
  {
    std::unique_lock lock(latch_mutex_);
    fanout = fanout_.load(std::memory_order_seq_cst);
    if (user_code == UserCode::kRefused && fanout->has_inline) return nullptr;
    if (info.remote && (returns_ || latched_messages_.AreMissed(info.id.publisher))) [[unlikely]] {
      lock.unlock();
      PublisherIsBack(info.id.publisher, info.id.incarnation);
      return Store(message, info, depth, bytes, user_code);
    }
    if (!info.remote) {  // So that numbers and times have the same order.
      numbers_.Number(info);
      info.publish_monotonic_ns = MonotonicNow();
    }
    stored = latched_messages_.Store(message, info, depth, bytes);
  }
  if (stored.beyond_limit > 0) {
    counts_.not_latched.fetch_add(stored.beyond_limit, std::memory_order_relaxed);
    LatchedMessages::SayBeyondLimit(core_.log(), name_);
  }
  return fanout;
}

void Channel::PublisherIsGone(std::uint64_t publisher) {
  LatchedMessages::Messages dropped;
  const std::scoped_lock lock(latch_mutex_);
  dropped = latched_messages_.MarkGone(publisher);
}

void Channel::PublisherIsBack(std::uint64_t publisher, std::optional<std::uint64_t> incarnation) {
  LatchedMessages::Return back;
  if (!incarnation) {  // Usually nobody has missed anything, and need not wait for callbacks.
    const std::scoped_lock lock(latch_mutex_);
    if (!latched_messages_.AreMissed(publisher)) return (void)latched_messages_.MarkBack(publisher);
  }
  const std::scoped_lock turn(returns_mutex_);
  {
    const std::scoped_lock lock(latch_mutex_);
    back = latched_messages_.MarkBack(publisher, incarnation);
    returns_ = !back.messages.empty();
  }
  back.Deliver();
  const std::scoped_lock lock(latch_mutex_);
  returns_ = false;
}

bool Channel::Inject(AnyMessage message, const TypeInfo& type, const MessageInfo& from,
                     std::shared_ptr<const void> credit, std::size_t latched, UserCode user_code) noexcept {
  if (core_.refusing()) return true;
  message = Wrapped(std::move(message), type);
  const epoch::Guard guard;
  MessageInfo info = from;
  info.remote = true;
  if (info.cause.origin == 0) info.cause = numbers_.Beginning(info);
  const Fanout* fanout = latched > 0 ? Store(message, info, latched, type.memory_bytes(message.get()), user_code)
                                     : fanout_.load(std::memory_order_seq_cst);
  if (fanout == nullptr || (user_code == UserCode::kRefused && fanout->has_inline)) return false;
  counts_.received.fetch_add(1, std::memory_order_relaxed);
  const std::size_t bytes = fanout->count_bytes ? type.memory_bytes(message.get()) : 0;
  Deliver(*fanout, message, info, credit, {bytes, false, true, nullptr, MonotonicNow()});
  return true;
}

PublishStatus Channel::PublishWait(const MessageOffer& offer, Reach reach,
                                   std::chrono::steady_clock::time_point deadline, const std::stop_token& stop) {
  PublishStatus status = Try(offer, reach);
  if (status == PublishStatus::kFull) {
    status = CallbackScope::InAny() ? PublishStatus::kWouldDeadlock
                                    : room_.Retry([&] { return Try(offer, reach); }, deadline, stop);
  }
  if (status != PublishStatus::kOk) counts_.refused.fetch_add(1, std::memory_order_relaxed);
  return status;
}

void Channel::Replace(std::shared_ptr<const Fanout> fanout) {
  const unsigned others = wrapping_.load(std::memory_order_relaxed) & ~kSharedRaw;
  wrapping_.store(others | (fanout->raw > 1 ? kSharedRaw : 0), std::memory_order_release);
  raw_.SetObserved(fanout->raw > 0);
  fanout_.store(fanout.get(), std::memory_order_seq_cst);
  std::swap(current_fanout_, fanout);
  epoch::Retire(std::move(fanout));
}

void Channel::Add(const std::shared_ptr<Node>& node) {
  const std::scoped_lock lock(wiring_mutex_, latch_mutex_);
  std::vector<QueuedMessage> kept = latched_messages_.ForNewNode(node);
  if (IsAnyType(*node->setting().type)) raw_.Expect(current_fanout_->nodes);
  if (other_type_.load(std::memory_order_relaxed) != nullptr || raw_.expected()) node->ExpectTwoForms();
  if (!kept.empty()) node->Preload(std::move(kept));
  std::vector<std::shared_ptr<Node>> nodes = current_fanout_->nodes;
  nodes.push_back(node);
  Replace(MakeFanout(std::move(nodes)));
}

void Channel::Remove(const Node& node) {
  const std::scoped_lock lock(wiring_mutex_);
  std::vector<std::shared_ptr<Node>> nodes = current_fanout_->nodes;
  std::erase_if(nodes, [&node](const std::shared_ptr<Node>& other) { return other.get() == &node; });
  if (nodes.size() != current_fanout_->nodes.size()) Replace(MakeFanout(std::move(nodes)));
}

void Channel::SetOutlet(std::shared_ptr<Outlet> outlet) {
  const std::scoped_lock lock(wiring_mutex_);
  outlet_.store(outlet.get(), std::memory_order_seq_cst);
  std::swap(current_outlet_, outlet);
  if (outlet) epoch::Retire(std::move(outlet));
}

void Channel::Latch(std::size_t count) {
  const std::scoped_lock lock(latch_mutex_);
  if (count > latched_.load(std::memory_order_relaxed)) latched_.store(count, std::memory_order_relaxed);
}

void Channel::ReplaceLatched(std::vector<AnyMessage> messages, const TypeInfo& type, std::uint64_t other) {
  for (AnyMessage& message : messages) message = Wrapped(std::move(message), type);
  LatchedMessages::Messages removed;  // Destroyed after the lock, as in Store().
  const std::scoped_lock lock(latch_mutex_);
  removed = latched_messages_.ReplaceOwn(numbers_.NewInfo(core_.publisher()), std::move(messages), other);
}

bool Channel::ForgetRemoteLatched() {
  LatchedMessages::Messages removed;  // Destroyed after the lock.
  const std::scoped_lock lock(wiring_mutex_, latch_mutex_);
  if (current_fanout_->nodes.empty()) removed = latched_messages_.ForgetRemote();
  return current_fanout_->nodes.empty();
}

std::vector<std::shared_ptr<Node>> Channel::Nodes() const {
  const std::scoped_lock lock(wiring_mutex_);
  return current_fanout_->nodes;
}

ThreadUse Channel::UseOfThread() const noexcept {
  const epoch::Guard guard;
  const Fanout* const fanout = fanout_.load(std::memory_order_seq_cst);
  if (fanout->has_inline) return ThreadUse::kInline;
  const auto wakes = [](const auto& node) { return node->WouldWakeWorker(); };
  return std::ranges::any_of(fanout->nodes, wakes) ? ThreadUse::kRunNode : ThreadUse::kNone;
}

const TypeInfo& Channel::InboundType() const noexcept {
  if (other_type_.load(std::memory_order_acquire) == nullptr && !raw_.expected()) return type();
  const epoch::Guard guard;
  const TypeInfo* const inbound = fanout_.load(std::memory_order_seq_cst)->inbound;
  return inbound != nullptr ? *inbound : IsRunTimeType(type()) ? AnyType() : type();
}

ChannelSnapshot Channel::Snapshot() const {
  ChannelSnapshot snapshot;
  snapshot.name = name_;
  snapshot.type = IsAnyType(type()) ? std::string() : type().name;
  snapshot.published = numbers_.last();
  snapshot.rate_hz = rate_.Hertz(snapshot.published, MonotonicNow());
  snapshot.closed = closed_.load(std::memory_order_relaxed);
  snapshot.latched = latched_.load(std::memory_order_relaxed);
  counts_.Fill(snapshot);
  for (const std::shared_ptr<Node>& node : Nodes()) snapshot.nodes.push_back(node->Snapshot());
  return snapshot;
}

PublishStatus Publish(Channel& channel, const MessageOffer& offer, Reach reach) noexcept {
  return channel.Publish(offer, reach);
}

PublishStatus PublishWait(Channel& channel, const MessageOffer& offer, Reach reach,
                          std::chrono::steady_clock::time_point deadline, const std::stop_token& stop) {
  return channel.PublishWait(offer, reach, deadline, stop);
}

}  // namespace hgros

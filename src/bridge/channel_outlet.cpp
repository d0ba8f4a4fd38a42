#include "hgros/bridge/channel_outlet.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "bridge/joined/joined_outbound.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/transport/ends_later.hpp"

namespace hgros {
namespace {

constexpr std::string_view kNoMemory = "was not written, because there is no memory for it";

CauseHead CauseOf(const MessageInfo& info, std::int64_t now) {
  CauseHead cause;
  cause.message = info.cause.message;
  if (info.cause.message != 0) cause.chain_origin = info.cause.origin;
  if (info.cause.began_ns != 0)
    cause.chain_age_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(now - info.cause.began_ns, 0));
  return cause;
}

}  // namespace

ChannelOutlet::ChannelOutlet(std::string channel, const TypeInfo& type, MessageId publisher, std::shared_ptr<Log> log,
                             OutletEvents events, std::shared_ptr<const HostClocks> clocks)
    : channel_(std::move(channel)),
      type_(type),
      publisher_(publisher),
      log_(std::move(log)),
      events_(std::move(events)),
      clocks_(std::move(clocks)) {}

void ChannelOutlet::Join(NetworkBridge& bridge) {
  {
    const std::scoped_lock lock(order_mutex_);
    joined_ = true;
    latch_.ChangeAll([this](OutletLatch::Kept& one) {
      if (one.type->users_codec) one.data = Encode(one.message, *one.type, {});
    });
  }
  std::shared_ptr<JoinedOutbound> transports = bridge.Advertise(channel_, type_, *this);
  const std::scoped_lock lock(transports_mutex_, order_mutex_);
  transports_ = std::move(transports);
}

void ChannelOutlet::Detach() {
  std::shared_ptr<JoinedOutbound> transports;
  {
    const EndsLater after_the_lock;
    const std::scoped_lock lock(transports_mutex_, order_mutex_);
    transports = std::move(transports_);
    promised_ = 0;
    if (transports) AddPast(*transports);
  }
  if (transports) transports->Close();
  subscribers_.store(0, std::memory_order_release);
}

void ChannelOutlet::SetStays(bool stays) {
  {
    const EndsLater after_the_lock;
    const std::scoped_lock lock(order_mutex_);
    if (std::exchange(stays_, stays) == stays) return;
    if (!stays) SendKept();
  }
  if (stays) events_.on_room();  // Publishers that wait for remote subscribers no longer need room there.
}

// Under order_mutex_. Messages that have stayed inside took no numbers, because subscribers would count them as lost.
// Those that are latched get them now.
void ChannelOutlet::SendKept() {
  auto numbered = latch_.NumberThose([this](OutletLatch::Kept& one) { Number(one.head, one.own_number); });
  for (OutletLatch::Kept& one : numbered) {
    if (!transports_ || transports_->subscriber_count() == 0) return;  // Later ones ask for what is latched.
    if (!one.data) one.data = Encode(one.message, *one.type, {});
    // For those who have no room, it waits.
    if (one.data->owner == nullptr || transports_->Reserve() == PublishStatus::kNoMemory) continue;
    (void)transports_->Commit(one.head, *one.data);
  }
}

// The two numbers differ: not every message was sent, and two threads may come here in another order.
void ChannelOutlet::Number(PacketHead& head, std::uint64_t own_number) noexcept {
  head.id.sequence = ++sequence_;
  if (own_number != 0) head.cause.unsent = static_cast<std::int64_t>(own_number - head.id.sequence);
  if (own_number == 0 && events_.on_numbered) events_.on_numbered(head);
}

bool ChannelOutlet::HasUnfinished() const {
  const EndsLater after_the_lock;
  const std::scoped_lock lock(order_mutex_);
  return promised_ > 0 || (transports_ && (transports_->stats().queued_bytes > 0 || transports_->Unfinished() > 0));
}

std::size_t ChannelOutlet::Unsent() const {
  const EndsLater after_the_lock;
  const std::scoped_lock lock(order_mutex_);
  return transports_ && transports_->stats().queued_bytes > 0 ? transports_->Unfinished() : 0;
}

void ChannelOutlet::AddPast(const JoinedOutbound& left) {
  const OutboundStats stats = left.stats();
  past_.sent += stats.sent;
  past_.dropped += stats.dropped;
  past_.missed += stats.missed + left.Unfinished();
  past_.copied += stats.copied;
}

std::optional<Block> ChannelOutlet::Loan(std::size_t size_bytes) {
  loans_.fetch_add(1, std::memory_order_relaxed);
  const std::shared_lock lock(transports_mutex_);
  std::optional<Block> block = transports_ ? transports_->Loan(size_bytes) : std::nullopt;
  if (!block) heap_loans_.fetch_add(1, std::memory_order_relaxed);
  return block;
}

bool ChannelOutlet::wanted() const noexcept {
  const bool first = !published_.load(std::memory_order_relaxed) && events_.on_first_publish();
  if (first) published_.store(true, std::memory_order_relaxed);
  return heard_.load(std::memory_order_relaxed) || latched_.load(std::memory_order_relaxed) > 0;
}

// Memory is taken here, before the message is promised to anybody, because that is where a lack of memory shows. Not
// under order_mutex_, because this may take long. The size is computed once, for Commit() as well.
PublishStatus ChannelOutlet::Reserve(const void* message, const TypeInfo& type, PreparedMessage& prepared) noexcept {
  const bool listened = subscriber_count() > 0;
  std::optional<std::size_t> size;
  if (listened && type.encoded_bytes != nullptr) size = type.encoded_bytes(message);
  if (size.value_or(0) > kMaxMessageBytes) return PublishStatus::kTooLarge;
  PublishStatus status = PublishStatus::kNoMemory;
  {
    std::shared_lock transports_stay(transports_mutex_, std::defer_lock);
    if (size) transports_stay.lock();
    {
      const EndsLater after_the_lock;
      const std::scoped_lock lock(order_mutex_);
      if (stays_) {
        prepared.state = PreparedMessage::State::kStays;
        return PublishStatus::kOk;
      }
      if (transports_) {
        if (const PublishStatus promise = transports_->Reserve(); promise != PublishStatus::kOk) return promise;
        ++promised_;
      }
    }
    try {
      status = Prepare(message, type, size, listened, prepared);
    } catch (const std::bad_alloc&) {  // The status says it.
    }
  }
  if (status != PublishStatus::kOk) Cancel();
  return status == PublishStatus::kNoMemory ? RefuseForMemory() : status;
}

PublishStatus ChannelOutlet::Prepare(const void* message, const TypeInfo& type, std::optional<std::size_t> size_bytes,
                                     bool listened, PreparedMessage& prepared) {
  using State = PreparedMessage::State;
  if (size_bytes) {
    const bool in_place = type.encode_in_place != nullptr;
    std::optional<Block> loan;
    if (transports_ && !transports_->FindMemory(*size_bytes, in_place ? type.large_part(message) : Bytes(), loan)) {
      return PublishStatus::kNoMemory;
    }
    if (!loan && !in_place) loan = Block::Allocate(*size_bytes);
    if (loan) prepared = {State::kMemory, std::move(*loan)};
  } else if (type.encode_copy != nullptr && (listened || (latched_ > 0 && WritesWhenLatched(type)))) {
    Payload data = type.encode_copy(message);
    if (listened && data.bytes.size() > kMaxMessageBytes) return PublishStatus::kTooLarge;
    prepared = {State::kEncoded, data.owner == nullptr ? Block() : Block(std::move(data))};
  } else if (listened && type.encode != nullptr && type.memory_bytes(message) > kMaxMessageBytes) {
    // A codec that shares the message: only the size is kept.
    const std::size_t size = type.encode(AnyMessage(AnyMessage(), message)).bytes.size();
    if (size > kMaxMessageBytes) return PublishStatus::kTooLarge;
  }
  return PublishStatus::kOk;
}

PublishStatus ChannelOutlet::RefuseForMemory() noexcept {
  try {
    log_->WriteLimited(LogLevel::kError, "memory " + channel_,
                       "There is no memory to write a message on channel \"" + channel_ +
                           "\" for other sessions; it was not published. Publish smaller messages, or raise the memory "
                           "limit of the process or of its control group.");
  } catch (const std::bad_alloc&) {  // The status says it.
  }
  return PublishStatus::kNoMemory;
}

void ChannelOutlet::Cancel() noexcept {
  const EndsLater after_the_lock;
  const std::scoped_lock lock(order_mutex_);
  CancelPromise();
}

// Under order_mutex_. A message may have been reserved before there were transports.
void ChannelOutlet::CancelPromise() noexcept {
  promised_ -= promised_ > 0 ? 1 : 0;
  if (transports_) transports_->Cancel();
}

// A message of which nothing is prepared is in memory already, or its first subscriber came after Reserve().
Payload ChannelOutlet::TryEncode(const AnyMessage& message, const TypeInfo& type, PreparedMessage&& prepared,
                                 Lend lend) {
  using State = PreparedMessage::State;
  if (prepared.state == State::kEncoded) return prepared.block.payload();
  if (type.encode_in_place != nullptr) {
    Payload payload = prepared.state == State::kNothing ? type.encode_in_place(message.get()) : Payload();
    if (payload.owner != nullptr) return payload;
    copied_.fetch_add(1, std::memory_order_relaxed);
  }
  if (prepared.state == State::kNothing && type.encode_into != nullptr && lend == Lend::kYes) {
    const std::shared_lock lock(transports_mutex_);
    auto loan = transports_ ? transports_->Loan(type.encoded_bytes(message.get())) : std::nullopt;
    if (loan) prepared = {State::kMemory, std::move(*loan)};
  }
  if (prepared.state == State::kMemory && type.encode_into(message.get(), prepared.block.writable())) {
    return prepared.block.payload();
  }
  return type.encode(message);
}

Payload ChannelOutlet::Encode(const AnyMessage& message, const TypeInfo& type, PreparedMessage&& prepared,
                              Lend lend) noexcept {
  Payload payload;
  bool memory = true;
  try {
    payload = TryEncode(message, type, std::move(prepared), lend);
  } catch (const std::bad_alloc&) {
    memory = false;
  }
  const std::size_t size = payload.bytes.size();
  // Reserve() has not found a size above the limit in two cases: a codec that shares a message of little memory, and a
  // subscriber that came later.
  if (payload.owner != nullptr && size <= kMaxMessageBytes) {
    encoded_.fetch_add(1, std::memory_order_relaxed);
    encoded_bytes_.fetch_add(size, std::memory_order_relaxed);
    return payload;
  }
  CountNotEncodable([&] {
    if (!memory) return std::string(kNoMemory);
    if (size <= kMaxMessageBytes) return "could not be written as " + type_.name;
    return "has " + std::to_string(size) + " bytes; sessions send at most " + std::to_string(kMaxMessageBytes);
  });
  return {};
}

template <typename Why>
void ChannelOutlet::CountNotEncodable(const Why& why) noexcept {
  not_encodable_.fetch_add(1, std::memory_order_relaxed);
  try {
    log_->WriteLimited(LogLevel::kError, "encode " + channel_,
                       "A message on channel \"" + channel_ + "\" " + why() + "; other sessions do not get it.");
  } catch (const std::bad_alloc&) {  // It is said with a later message.
  }
}

bool ChannelOutlet::Commit(const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
                           PreparedMessage&& prepared) noexcept {
  const bool promised = prepared.state != PreparedMessage::State::kStays;
  try {
    return TryCommit(message, type, info, std::move(prepared));
  } catch (const std::bad_alloc&) {
    if (promised) Cancel();
    CountNotEncodable([] { return std::string(kNoMemory); });
    return false;
  }
}

bool ChannelOutlet::TryCommit(const AnyMessage& message, const TypeInfo& type, const MessageInfo& info,
                              PreparedMessage&& prepared) {
  const std::size_t depth = latched_.load(std::memory_order_relaxed);
  const bool stays = prepared.state == PreparedMessage::State::kStays;
  const bool listened = !stays && subscriber_count() > 0;
  if (!listened && depth == 0) {
    if (stays) return true;
    const std::scoped_lock lock(order_mutex_);
    ++sequence_;
    CancelPromise();
    return true;
  }
  // Outside the lock: encoding a large message takes as long as sending it.
  std::optional<Payload> data;
  if (listened || WritesWhenLatched(type)) data = Encode(message, type, std::move(prepared), Lend::kYes);
  PacketHead head = NewHead(depth, clocks_->Now().nanoseconds);
  head.cause = CauseOf(info, head.publish_monotonic_ns);

  OutletLatch::Messages dropped;  // Destroyed after the locks.
  const EndsLater after_the_lock;
  const std::scoped_lock lock(order_mutex_);
  bool counted = listened;
  if (depth > 0) {
    if (!stays) Number(head, info.id.sequence);
    // The bridge has come meanwhile.
    if (!data && WritesWhenLatched(type)) data = Encode(message, type, {});
    dropped =
        latch_.Keep({message, &type, head, info.id.sequence, WritesWhenLatched(type) ? data : std::nullopt}, depth);
    if (stays && !stays_) SendKept();
    // A subscriber is counted before it asks for latched messages. So either it found this message there, or it is
    // counted now.
    counted = listened || (!stays && transports_ && transports_->subscriber_count() > 0);
    if (counted && !data) data = Encode(message, type, {});
  } else if (data->owner != nullptr) {
    Number(head, info.id.sequence);
  }
  if (!transports_ || stays) return true;
  if (!counted || data->owner == nullptr) {
    CancelPromise();
    return !counted;
  }
  promised_ -= promised_ > 0 ? 1 : 0;
  return transports_->Commit(head, *data);
}

PacketHead ChannelOutlet::NewHead(std::size_t depth, std::int64_t publish_time_ns) const {
  PacketHead head;
  head.channel = channel_;
  head.type_name = type_.name;
  head.encoding = type_.encoding;
  head.fingerprint = type_.fingerprint;
  head.id = publisher_;
  head.publish_time_ns = publish_time_ns;
  head.publish_monotonic_ns = MonotonicNow();
  head.latched = static_cast<std::uint32_t>(depth);
  return head;
}

// With numbers of an earlier incarnation: for those who get it, nothing is missing before the next message, and it is
// an old one for those who have heard of this outlet before.
bool ChannelOutlet::KeepLatched(AnyMessage message, Payload data, std::int64_t publish_time_ns) {
  const std::size_t depth = latched_.load(std::memory_order_relaxed);
  if (depth == 0) return false;
  PacketHead head = NewHead(depth, publish_time_ns);
  --head.id.incarnation;
  OutletLatch::Messages dropped;  // Destroyed after the lock.
  const std::scoped_lock lock(order_mutex_);
  head.id.sequence = ++taken_over_;
  dropped = latch_.Keep({std::move(message), &type_, std::move(head), 0, std::move(data)}, depth);
  return true;
}

void ChannelOutlet::ForgetLatched() { (void)latch_.Clear(); }

std::vector<OutboundMessage> ChannelOutlet::Latched(SessionId /*subscriber*/) noexcept {
  try {
    return TryLatched();
  } catch (const std::bad_alloc&) {
    CountNotEncodable([] { return std::string(kNoMemory); });
    return {};
  }
}

std::vector<OutboundMessage> ChannelOutlet::TryLatched() {
  OutletLatch::Messages kept = latch_.All();
  std::vector<OutboundMessage> messages;
  messages.reserve(kept.size());
  for (OutletLatch::Kept& one : kept) {
    if (one.head.id.sequence == 0) continue;  // It stays inside.
    if (!one.data) one.data = Encode(one.message, *one.type, {});
    if (one.data->owner != nullptr) messages.push_back({std::move(one.head), std::move(*one.data)});
  }
  return messages;
}

void ChannelOutlet::OnSubscribers(std::size_t count) noexcept {
  // Done first: a thread that sees the subscriber and publishes must find that the outlet is wanted.
  if (count > 0) heard_.store(true, std::memory_order_relaxed);
  subscribers_.store(count, std::memory_order_release);
  events_.on_subscribers();
}

std::vector<SessionId> ChannelOutlet::Subscribers() const {
  const std::scoped_lock lock(order_mutex_);
  return transports_ ? transports_->Subscribers() : std::vector<SessionId>();
}

void ChannelOutlet::AddTo(ChannelTraffic& traffic) const {
  traffic.encoded = encoded_.load(std::memory_order_relaxed);
  traffic.encoded_bytes = encoded_bytes_.load(std::memory_order_relaxed);
  traffic.not_encodable = not_encodable_.load(std::memory_order_relaxed);
  traffic.loans = loans_.load(std::memory_order_relaxed);
  traffic.heap_loans = heap_loans_.load(std::memory_order_relaxed);
  const std::scoped_lock lock(order_mutex_);
  if (transports_) {
    traffic.out = transports_->stats();
    // Commit uses this number. It is updated a moment after the transport's own count.
    traffic.out.subscribers = subscriber_count();
  }
  traffic.out.sent += past_.sent;
  traffic.out.dropped += past_.dropped;
  traffic.out.missed += past_.missed;
  traffic.out.copied += past_.copied + copied_.load(std::memory_order_relaxed);
}

}  // namespace hgros

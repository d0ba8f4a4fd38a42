#include "hgros/bridge/channel_outlet.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "bridge/joined_channels.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/transport/ends_later.hpp"

namespace hgros {
namespace {

// Reading the limits of the control group costs as much as copying this much.
constexpr std::size_t kLargeBytes = 1u << 20;

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
    const std::scoped_lock lock(order_mutex_, latch_mutex_);
    joined_ = true;
    for (Kept& one : kept_) {
      if (one.type->users_codec) one.data = Encode(one.message, *one.type, {}, nullptr);
    }
  }
  std::shared_ptr<JoinedOutbound> transports = bridge.Advertise(channel_, type_, *this);
  const std::scoped_lock lock(order_mutex_);
  transports_ = std::move(transports);
}

void ChannelOutlet::Detach() {
  std::shared_ptr<JoinedOutbound> transports;
  {
    const std::scoped_lock lock(order_mutex_);
    transports = std::move(transports_);
  }
  if (transports) transports->Close();
  subscribers_.store(0, std::memory_order_release);
}

void ChannelOutlet::Latch(std::size_t count) {
  if (count > latched_.load(std::memory_order_relaxed)) latched_.store(count, std::memory_order_relaxed);
}

std::optional<Block> ChannelOutlet::Loan(std::size_t size_bytes) {
  loans_.fetch_add(1, std::memory_order_relaxed);
  std::optional<Block> block = LendUnlocked(size_bytes);
  if (!block) heap_loans_.fetch_add(1, std::memory_order_relaxed);
  return block;
}

std::optional<Block> ChannelOutlet::LendLocked(std::size_t size_bytes) {
  return transports_ ? transports_->Loan(size_bytes) : std::nullopt;
}

std::optional<Block> ChannelOutlet::LendUnlocked(std::size_t size_bytes) {
  const std::scoped_lock lock(order_mutex_);
  return LendLocked(size_bytes);
}

bool ChannelOutlet::wanted() const noexcept {
  if (!published_.load(std::memory_order_relaxed) && events_.on_first_publish()) {
    published_.store(true, std::memory_order_relaxed);
  }
  return heard_.load(std::memory_order_relaxed) || latched_.load(std::memory_order_relaxed) > 0;
}

// Memory is taken here, before the message is promised to anybody, because that is where a lack of memory shows. The
// size is computed once, for Commit() as well.
PublishStatus ChannelOutlet::Reserve(const void* message, const TypeInfo& type, PreparedMessage& prepared) noexcept {
  const bool listened = subscriber_count() > 0;
  std::optional<std::size_t> size;
  if (listened && type.encoded_bytes != nullptr) size = type.encoded_bytes(message);
  if (size.value_or(0) > kMaxMessageBytes) return PublishStatus::kTooLarge;
  std::optional<Block> loan;
  bool memory = true;
  {
    const EndsLater after_the_lock;
    const std::scoped_lock lock(order_mutex_);
    if (transports_) {
      if (const PublishStatus status = transports_->Reserve(); status != PublishStatus::kOk) return status;
      memory = !size || FindMemory(message, type, *size, loan);
      if (!memory) transports_->Cancel();
    }
  }
  if (!memory) return RefuseForMemory();
  if (loan) {
    prepared = {PreparedMessage::State::kMemory, std::move(*loan)};
    return PublishStatus::kOk;
  }
  const PublishStatus status = Prepare(message, type, size, listened, prepared);
  if (status != PublishStatus::kOk) Cancel();
  return status;
}

bool ChannelOutlet::FindMemory(const void* message, const TypeInfo& type, std::size_t size_bytes,
                               std::optional<Block>& loan) noexcept {
  const bool in_place = type.encode_in_place != nullptr;
  try {
    if (!in_place) loan = transports_->Loan(size_bytes);
    return loan || size_bytes < kLargeBytes ||
           transports_->HasMemoryFor(size_bytes, in_place ? type.large_part(message) : Bytes());
  } catch (const std::bad_alloc&) {
    return false;
  }
}

PublishStatus ChannelOutlet::Prepare(const void* message, const TypeInfo& type, std::optional<std::size_t> size_bytes,
                                     bool listened, PreparedMessage& prepared) noexcept {
  using State = PreparedMessage::State;
  try {
    if (size_bytes && type.encode_in_place == nullptr) {
      prepared = {State::kMemory, Block::Allocate(*size_bytes)};
    } else if (type.encode_copy != nullptr && (listened || (latched_ > 0 && WritesWhenLatched(type)))) {
      Payload data = type.encode_copy(message);
      if (listened && data.bytes.size() > kMaxMessageBytes) return PublishStatus::kTooLarge;
      prepared = {State::kEncoded, data.owner == nullptr ? Block() : Block(std::move(data))};
    } else if (listened && !size_bytes && type.encode != nullptr && type.memory_bytes(message) > kMaxMessageBytes) {
      // A codec that shares the message: only the size is kept.
      const std::size_t size = type.encode(AnyMessage(AnyMessage(), message)).bytes.size();
      if (size > kMaxMessageBytes) return PublishStatus::kTooLarge;
    }
    return PublishStatus::kOk;
  } catch (const std::bad_alloc&) {
    return RefuseForMemory();
  }
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
  if (transports_) transports_->Cancel();
}

// A message of which nothing is prepared needs no memory, or its first subscriber came after Reserve().
Payload ChannelOutlet::TryEncode(const AnyMessage& message, const TypeInfo& type, PreparedMessage&& prepared,
                                 Lend lend) {
  using State = PreparedMessage::State;
  if (prepared.state == State::kEncoded) return prepared.block.payload();
  if (type.encode_in_place != nullptr) {
    Payload payload = type.encode_in_place(message.get());
    if (payload.owner != nullptr) return payload;
    copied_.fetch_add(1, std::memory_order_relaxed);
  }
  if (prepared.state == State::kNothing && type.encode_into != nullptr && lend != nullptr) {
    if (auto loan = (this->*lend)(type.encoded_bytes(message.get()))) prepared = {State::kMemory, std::move(*loan)};
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
  not_encodable_.fetch_add(1, std::memory_order_relaxed);
  try {
    log_->WriteLimited(LogLevel::kError, "encode " + channel_,
                       "A message on channel \"" + channel_ + "\" " +
                           (size > kMaxMessageBytes ? "has " + std::to_string(size) + " bytes; sessions send at most " +
                                                          std::to_string(kMaxMessageBytes)
                            : memory ? "could not be written as " + type_.name
                                     : std::string("was not written, because there is no memory for it")) +
                           "; other sessions do not get it.");
  } catch (const std::bad_alloc&) {  // It is said with a later message.
  }
  return {};
}

bool ChannelOutlet::Commit(const AnyMessage& message, const TypeInfo& type, PreparedMessage&& prepared) noexcept {
  const std::size_t depth = latched_.load(std::memory_order_relaxed);
  const bool listened = subscriber_count() > 0;
  if (!listened && depth == 0) {
    const std::scoped_lock lock(order_mutex_);
    ++sequence_;
    if (transports_) transports_->Cancel();
    return true;
  }
  // Outside the lock: encoding a large message takes as long as sending it.
  std::optional<Payload> data;
  if (listened || WritesWhenLatched(type)) {
    data = Encode(message, type, std::move(prepared), &ChannelOutlet::LendUnlocked);
  }
  PacketHead head;
  head.channel = channel_;
  head.type_name = type_.name;
  head.encoding = type_.encoding;
  head.fingerprint = type_.fingerprint;
  head.id = publisher_;
  head.publish_time_ns = clocks_->Now().nanoseconds;
  head.publish_monotonic_ns = MonotonicNow();
  head.latched = static_cast<std::uint32_t>(depth);

  std::vector<Kept> dropped;  // Destroyed after the locks: a message's destructor is the user's code.
  const EndsLater after_the_lock;
  const std::scoped_lock lock(order_mutex_);
  bool counted = listened;
  if (depth > 0) {
    head.id.sequence = ++sequence_;
    // The bridge has come meanwhile.
    if (!data && WritesWhenLatched(type)) data = Encode(message, type, {}, nullptr);
    Keep({message, &type, head, WritesWhenLatched(type) ? data : std::nullopt}, depth, dropped);
    // A subscriber is counted before it asks for latched messages. So either it found this message there, or it is
    // counted now.
    counted = listened || (transports_ && transports_->subscriber_count() > 0);
    if (counted && !data) data = Encode(message, type, {}, &ChannelOutlet::LendLocked);
  } else if (data->owner != nullptr) {
    head.id.sequence = ++sequence_;
  }
  if (!transports_) return true;
  if (counted && data->owner != nullptr) return transports_->Commit(head, *data);
  transports_->Cancel();
  return !counted;
}

bool ChannelOutlet::WritesWhenLatched(const TypeInfo& type) const noexcept {
  return type.users_codec && joined_.load(std::memory_order_relaxed);
}

void ChannelOutlet::Keep(Kept&& message, std::size_t depth, std::vector<Kept>& dropped) {
  const std::scoped_lock latch(latch_mutex_);
  kept_.push_back(std::move(message));
  while (kept_.size() > depth) {
    dropped.push_back(std::move(kept_.front()));
    kept_.pop_front();
  }
}

std::vector<OutboundMessage> ChannelOutlet::Latched(SessionId /*subscriber*/) noexcept {
  std::deque<Kept> kept;
  {
    const std::scoped_lock lock(latch_mutex_);
    kept = kept_;
  }
  std::vector<OutboundMessage> messages;
  for (Kept& one : kept) {
    if (!one.data) one.data = Encode(one.message, *one.type, {}, nullptr);
    if (one.data->owner != nullptr) messages.push_back({one.head, std::move(*one.data)});
  }
  return messages;
}

void ChannelOutlet::OnRoom() noexcept { events_.on_room(); }

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
    traffic.out.subscribers =
        subscriber_count();  // Commit uses this number; it is updated a moment after the transport's own count.
  }
  traffic.out.copied += copied_.load(std::memory_order_relaxed);
}

}  // namespace hgros

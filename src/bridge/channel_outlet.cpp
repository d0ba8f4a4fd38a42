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

// A message of this size gets its memory before it is promised to anybody, because that is where a lack of memory
// shows.
constexpr std::size_t kLargeBytes = 1u << 20;

// The encoded size; none if it is only known once the message is encoded.
std::optional<std::size_t> EncodedBytes(const void* message, const TypeInfo& type) {
  if (type.encoded_bytes != nullptr) return type.encoded_bytes(message);
  // The user's codec: a message that needs little memory is not encoded twice.
  if (type.encode == nullptr || type.memory_bytes(message) <= kMaxMessageBytes) return std::nullopt;
  return type.encode(AnyMessage(AnyMessage(), message)).bytes.size();
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
    const std::scoped_lock lock(order_mutex_, latch_mutex_);
    joined_ = true;
    for (Kept& one : kept_) {
      if (one.type->users_codec) one.data = Encode(one.message, *one.type, nullptr);
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
  transports.reset();
  subscribers_.store(0, std::memory_order_release);
}

void ChannelOutlet::Latch(std::size_t count) {
  if (count > latched_.load(std::memory_order_relaxed)) latched_.store(count, std::memory_order_relaxed);
}

std::optional<Block> ChannelOutlet::Loan(std::size_t size_bytes) {
  std::shared_ptr<JoinedOutbound> transports;
  {
    const std::scoped_lock lock(order_mutex_);
    transports = transports_;
  }
  loans_.fetch_add(1, std::memory_order_relaxed);
  std::optional<Block> block = transports ? transports->Loan(size_bytes) : std::nullopt;
  if (!block) heap_loans_.fetch_add(1, std::memory_order_relaxed);
  return block;
}

bool ChannelOutlet::wanted() const noexcept {
  if (!published_.load(std::memory_order_relaxed) && events_.on_first_publish()) {
    published_.store(true, std::memory_order_relaxed);
  }
  return heard_.load(std::memory_order_relaxed) || latched_.load(std::memory_order_relaxed) > 0;
}

PublishStatus ChannelOutlet::Reserve(const void* message, const TypeInfo& type) noexcept {
  if (subscriber_count() > 0) {
    if (const PublishStatus status = ReserveMemory(message, type); status != PublishStatus::kOk) return status;
  }
  PublishStatus status = PublishStatus::kOk;
  {
    const EndsLater after_the_lock;
    const std::scoped_lock lock(order_mutex_);
    if (transports_) status = transports_->Reserve();
  }
  if (status != PublishStatus::kOk) ReleaseMemory(message, type);
  return status;
}

PublishStatus ChannelOutlet::ReserveMemory(const void* message, const TypeInfo& type) noexcept {
  try {
    const auto size = EncodedBytes(message, type);
    if (!size || *size < kLargeBytes) return PublishStatus::kOk;
    if (*size > kMaxMessageBytes) return PublishStatus::kTooLarge;
    if (type.encode_into == nullptr || type.encode_in_place != nullptr) return PublishStatus::kOk;
    std::shared_ptr<JoinedOutbound> transports;
    {
      const std::scoped_lock lock(order_mutex_);
      transports = transports_;
    }
    std::optional<Block> block = transports ? transports->Loan(*size) : std::nullopt;
    if (!block && transports && !transports->HasMemoryFor(*size)) throw std::bad_alloc();
    if (!block) block = Block::Allocate(*size);
    const std::scoped_lock lock(memory_mutex_);
    memory_.push_back(std::move(*block));
    memory_count_.store(memory_.size(), std::memory_order_relaxed);
    return PublishStatus::kOk;
  } catch (const std::bad_alloc&) {
    log_->WriteLimited(LogLevel::kError, "memory " + channel_,
                       "There is no memory to write a message on channel \"" + channel_ +
                           "\" for other sessions; it was not published. Publish smaller messages, or raise the memory "
                           "limit of the process or of its control group.");
    return PublishStatus::kNoMemory;
  }
}

std::optional<Block> ChannelOutlet::TakeMemory(std::size_t size_bytes) noexcept {
  if (memory_count_.load(std::memory_order_relaxed) == 0) return std::nullopt;
  const std::scoped_lock lock(memory_mutex_);
  const auto found = std::ranges::find(memory_, size_bytes, &Block::size);
  if (found == memory_.end()) return std::nullopt;
  Block block = std::move(*found);
  memory_.erase(found);
  memory_count_.store(memory_.size(), std::memory_order_relaxed);
  return block;
}

void ChannelOutlet::ReleaseMemory(const void* message, const TypeInfo& type) noexcept {
  if (memory_count_.load(std::memory_order_relaxed) == 0 || type.encoded_bytes == nullptr) return;
  (void)TakeMemory(type.encoded_bytes(message));
}

void ChannelOutlet::Cancel() noexcept {
  const EndsLater after_the_lock;
  const std::scoped_lock lock(order_mutex_);
  if (transports_) transports_->Cancel();
}

Payload ChannelOutlet::EncodeInto(const AnyMessage& message, const TypeInfo& type, JoinedOutbound& transports) {
  if (type.encode_into == nullptr) return {};
  const std::size_t size = type.encoded_bytes(message.get());
  std::optional<Block> block = TakeMemory(size);
  if (!block) block = transports.Loan(size);
  if (!block || !type.encode_into(message.get(), block->writable())) return {};
  return block->payload();
}

Payload ChannelOutlet::TryEncode(const AnyMessage& message, const TypeInfo& type, JoinedOutbound* transports) {
  Payload payload;
  if (type.encode_in_place != nullptr) {
    payload = type.encode_in_place(message.get());
    if (payload.owner == nullptr) copied_.fetch_add(1, std::memory_order_relaxed);
  }
  if (payload.owner == nullptr && transports != nullptr) payload = EncodeInto(message, type, *transports);
  if (payload.owner == nullptr) payload = type.encode(message);
  return payload;
}

Payload ChannelOutlet::Encode(const AnyMessage& message, const TypeInfo& type, JoinedOutbound* transports) noexcept {
  Payload payload;
  bool memory = true;
  try {
    payload = TryEncode(message, type, transports);
  } catch (const std::bad_alloc&) {
    memory = false;
  }
  const std::size_t size = payload.bytes.size();
  // Reserve() has not found a size above the limit in two cases: the user's codec, and a subscriber that came later.
  if (payload.owner != nullptr && size <= kMaxMessageBytes) return payload;
  not_encodable_.fetch_add(1, std::memory_order_relaxed);
  log_->WriteLimited(LogLevel::kError, "encode " + channel_,
                     "A message on channel \"" + channel_ + "\" " +
                         (size > kMaxMessageBytes ? "has " + std::to_string(size) + " bytes; sessions send at most " +
                                                        std::to_string(kMaxMessageBytes)
                          : memory ? "could not be written as " + type_.name
                                   : std::string("was not written, because there is no memory for it")) +
                         "; other sessions do not get it.");
  return {};
}

void ChannelOutlet::Commit(const AnyMessage& message, const TypeInfo& type) noexcept {
  const std::size_t depth = latched_.load(std::memory_order_relaxed);
  const bool listened = subscriber_count() > 0;
  if (!listened && depth == 0) {
    ReleaseMemory(message.get(), type);
    const std::scoped_lock lock(order_mutex_);
    ++sequence_;
    if (transports_) transports_->Cancel();
    return;
  }
  // Outside the lock: encoding a large message takes as long as sending it.
  std::optional<Payload> data;
  if (listened || WritesWhenLatched(type)) {
    std::shared_ptr<JoinedOutbound> transports;
    {
      const std::scoped_lock lock(order_mutex_);
      transports = transports_;
    }
    data = Encode(message, type, WritesWhenLatched(type) ? nullptr : transports.get());
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
    if (!data && WritesWhenLatched(type)) data = Encode(message, type, nullptr);  // A subscriber has joined meanwhile.
    Keep({message, &type, head, WritesWhenLatched(type) ? data : std::nullopt}, depth, dropped);
    // A subscriber is counted before it asks for latched messages. So either it found this message there, or it is
    // counted now.
    counted = listened || (transports_ && transports_->subscriber_count() > 0);
    if (counted && !data) data = Encode(message, type, transports_.get());
  } else if (data->owner != nullptr) {
    head.id.sequence = ++sequence_;
  }
  if (!data) ReleaseMemory(message.get(), type);
  if (!transports_) return;
  if (counted && data->owner != nullptr) {
    transports_->Commit(head, *data);
  } else {
    transports_->Cancel();
  }
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
    if (!one.data) one.data = Encode(one.message, *one.type, nullptr);
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
  std::shared_ptr<JoinedOutbound> transports;
  {
    const std::scoped_lock lock(order_mutex_);
    transports = transports_;
  }
  return transports ? transports->Subscribers() : std::vector<SessionId>();
}

void ChannelOutlet::AddTo(ChannelTraffic& traffic) const {
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

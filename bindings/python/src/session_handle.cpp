#include "session_handle.hpp"

#include <cstring>
#include <new>
#include <optional>
#include <utility>

#include "hgros/base/error.hpp"
#include "program_line.hpp"

namespace hgros::python {
namespace {

// From here on, one more copy costs more than asking for memory that receivers read.
constexpr std::size_t kLoanFrom = 64 * 1024;

}  // namespace

void SubscriptionHandle::End() {
  if (of_parent()) return;
  inbox_->Close();  // First: its thread may wait for room.
  subscription_.Reset();
}

SessionHandle::SessionHandle(Config config, const std::string& name, std::shared_ptr<Inbox> log)
    : session_(std::make_shared<Session>(
          std::move(config),
          SessionOptions{.name = name, .log = [inbox = std::move(log)](LogLevel level, std::string_view text) {
                           inbox->Push(LogLine{level, std::string(text)});
                         }})) {}

std::shared_ptr<Session> SessionHandle::Use() const {
  RefuseInChild();
  const std::scoped_lock lock(mutex_);
  if (!session_) {
    throw Error("The session is closed.", {}, "Use it before close(), or inside its `with` block.");
  }
  return session_;
}

SessionHandle::Receiving::Receiving(SessionHandle& handle) : handle_(handle) {
  const std::scoped_lock lock(handle_.mutex_);
  session_ = handle_.session_;
  ++handle_.receiving_;
}

SessionHandle::Receiving::~Receiving() {
  const std::scoped_lock lock(handle_.mutex_);
  session_.reset();  // Not the last one: Close() keeps it.
  --handle_.receiving_;
  handle_.left_.notify_all();
}

void SessionHandle::Close() {
  if (of_parent()) return;
  std::shared_ptr<Session> last;
  std::unique_lock lock(mutex_);
  last.swap(session_);
  // So the session ends here, and not on a thread that receives.
  closing_ = true;
  if (last) last->WakeReceiver();
  left_.wait(lock, [this] { return receiving_ == 0; });
  lock.unlock();
}

bool SessionHandle::closed() const {
  RefuseInChild();
  const std::scoped_lock lock(mutex_);
  return session_ == nullptr;
}

Owned<SubscriptionHandle> SessionHandle::Subscribe(const std::string& channel, const std::shared_ptr<Inbox>& inbox,
                                                   const NodeOptions& options, const MessageSchema* type) {
  const auto session = Use();
  auto put = [inbox, known = false](const std::shared_ptr<const RawMessage>& message, const MessageInfo& info) mutable {
    if (!std::exchange(known, true)) inbox->SetNode(HandedOver::TakeFromRunningNode());
    inbox->Push(Heard{*message, info, Cause::Here()});
  };
  NodeOptions chosen = options;
  // A lossless inbox holds its thread; others only put a message into it.
  chosen.executor = options.queue.lossless() ? Executor::Dedicated() : Executor::Inline();
  const auto subscribe = [&] {
    return type == nullptr ? session->FromAnyRaw(channel, Invoke::kSerial, put, chosen)
                           : session->FromAnyRaw(channel, *type, Invoke::kSerial, put, chosen, ProgramLine());
  };
  auto subscription = subscribe();
  NodeSnapshot made = subscription.stats();
  if (made.queue.lossless() && made.executor.kind() == Executor::Kind::kInline) {
    // The configuration has made the queue lossless.
    subscription.Reset();
    inbox->Clear();  // The new subscription gets the latched messages again.
    chosen.executor = Executor::Dedicated();
    subscription = subscribe();
    made = subscription.stats();
  }
  inbox->SetQueue(made.queue);
  return MakeOwned<SubscriptionHandle>(std::move(subscription), inbox);
}

PublishStatus PublisherHandle::Publish(Bytes bytes,
                                       std::optional<std::chrono::steady_clock::time_point> deadline) const {
  if (bytes.size() < kLoanFrom) return Publish(Payload{bytes, nullptr}, deadline);
  std::optional<Block> block;
  try {
    block = Loan(bytes.size());
  } catch (const std::bad_alloc&) {
    return PublishStatus::kNoMemory;
  }
  std::memcpy(block->writable().data(), bytes.data(), bytes.size());
  return Publish(block->payload(), deadline);
}

PublishStatus PublisherHandle::Publish(const Payload& data,
                                       std::optional<std::chrono::steady_clock::time_point> deadline) const {
  RefuseInChild();
  const CauseScope cause(current_cause);
  return deadline ? publish_.Wait(data, *deadline) : publish_(data);
}

Block PublisherHandle::Loan(std::size_t size_bytes) const {
  RefuseInChild();
  const std::unique_ptr<Block> lent = lend_(size_bytes);
  return lent ? std::move(*lent) : Block::Allocate(size_bytes);
}

}  // namespace hgros::python

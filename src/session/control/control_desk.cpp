#include "session/control/control_desk.hpp"

#include <algorithm>
#include <exception>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/bridge/network_bridge.hpp"
#include "hgros/codec/message.hpp"
#include "session/observed/announced_type.hpp"

namespace hgros {
namespace {

// Limits against sessions that ask without end: a request that is dropped comes again.
constexpr std::size_t kMostWaiting = 64;
constexpr std::size_t kMostOfStrangers = 8;  // Of these. The others are for sessions that may steer this one.
constexpr std::size_t kMostBytes = 64 * 1024;
constexpr std::size_t kKeptReplies = 64;
constexpr std::uint32_t kCreditMessages = 16;

}  // namespace

void RequireOtherThanRequests(std::string_view channel, const CallSite& where) {
  if (channel != kControlChannel) return;
  throw Error("Channel \"" + std::string(channel) + "\" belongs to the library: a program cannot subscribe to it.",
              {where.ToString()},
              "Use `hgros control` or AskSessions() to change running sessions, and `control: off` to forbid it here.");
}

ControlDesk::ControlDesk(NetworkBridge& bridge, Means means) : means_(std::move(means)) {
  Demand demand;
  demand.queue_depth = demand.credit_messages = kCreditMessages;
  demand.credit_bytes = kCreditMessages * kMostBytes;
  requests_ = bridge.SubscribeUnannounced(std::string(kControlChannel),
                                          AnnouncedTypeOf<ControlRequest>("hgros.ControlRequest"), demand, *this);
}

ControlDesk::~ControlDesk() = default;

void ControlDesk::Close() {
  requests_.reset();
  const std::scoped_lock lock(mutex_);
  waiting_.clear();
  strangers_ = 0;
}

Accepted ControlDesk::Accept(InboundMessage&& message) noexcept {
  try {
    const Bytes bytes = message.data.bytes;
    const std::scoped_lock lock(mutex_);
    if (!message.trusted && strangers_ >= kMostOfStrangers) {  // Those that wait are logged.
      refused_.fetch_add(1, std::memory_order_relaxed);
      return Accepted::kNothing;
    }
    if (waiting_.size() >= kMostWaiting) return Accepted::kNothing;
    // A request that is too long is kept without its bytes, and refused later.
    const std::size_t size = bytes.size() <= kMostBytes ? bytes.size() : 0;
    Asked asked{message.from, message.trusted, std::string(reinterpret_cast<const char*>(bytes.data()), size)};
    means_.post([this] { Work(); });  // Before the request waits, because posting may throw.
    waiting_.push_back(std::move(asked));
    strangers_ += message.trusted ? 0 : 1;
  } catch (const std::exception&) {  // No memory: the request comes again.
  }
  return Accepted::kNothing;
}

void ControlDesk::Work() {
  Asked asked;
  {
    const std::scoped_lock lock(mutex_);
    if (waiting_.empty()) return;
    asked = std::move(waiting_.front());
    waiting_.pop_front();
    strangers_ -= asked.trusted ? 0 : 1;
  }
  try {
    Answer(asked);
  } catch (const std::exception& error) {
    means_.log->WriteLimited(LogLevel::kError, "control",
                             std::string("A request could not be answered. ") + error.what());
  }
}

void ControlDesk::Answer(const Asked& asked) {
  ControlRequest request;
  if (asked.bytes.empty() || !request.ParseFromString(asked.bytes)) {
    return CountRefused(asked.by, "the request cannot be read");
  }
  if (std::ranges::find(request.sessions(), means_.self.value) == request.sessions().end()) return;
  for (const auto& given : given_) {
    if (given->asker() == asked.by.value && given->number() == request.number()) return Send(given);
  }
  auto reply = std::make_shared<const ControlReply>(ReplyTo(asked, request));
  if (asked.by.value == 0) return;
  // Strangers must not displace what is kept for others.
  if (asked.trusted) given_.push_back(reply);
  if (given_.size() > kKeptReplies) given_.pop_front();
  Send(reply);
}

ControlReply ControlDesk::ReplyTo(const Asked& asked, const ControlRequest& request) {
  ControlReply reply;
  reply.set_version(kControlVersion);
  reply.set_asker(asked.by.value);
  reply.set_number(request.number());
  if (!asked.trusted) {
    reply.set_refusal(
        "Only sessions of the same user on the same host, and those whose CURVE key is in "
        "network.security.allowed_clients, may change something here.");
    if (request.action() == ControlRequest::DESCRIBE) return reply;  // It would change nothing.
    CountRefused(asked.by,
                 "it is neither a session of the same user on this host, nor is its CURVE key in allowed_clients");
    return reply;
  }
  if (request.version() == 0 || request.version() > kControlVersion) {
    reply.set_refusal("The session knows versions 1 to " + std::to_string(kControlVersion) +
                      " of such requests, not version " + std::to_string(request.version()) +
                      ". Use the same release of HyperGraph ROS on both sides.");
  } else {
    try {
      means_.obey(request, reply);
    } catch (const std::exception& error) {
      reply.set_refusal(error.what());
    }
  }
  if (request.action() == ControlRequest::DESCRIBE) return reply;  // It changes nothing.
  if (!reply.refusal().empty()) {
    CountRefused(asked.by, reply.refusal());
  } else {
    // As an error, because no level hides these.
    means_.log->Write(LogLevel::kError,
                      "Session " + means_.name_of(asked.by) + " has steered this session. " + reply.done());
  }
  return reply;
}

void ControlDesk::CountRefused(SessionId by, const std::string& why) {
  refused_.fetch_add(1, std::memory_order_relaxed);
  means_.log->WriteLimited(LogLevel::kWarning, "control refused",
                           "A request to change something in this session was refused. It came from " +
                               (by.value == 0 ? "a program that is no session" : "session " + means_.name_of(by)) +
                               ": " + why + (why.ends_with('.') ? "" : "."));
}

void ControlDesk::Send(const std::shared_ptr<const ControlReply>& reply) {
  if (!replies_) {
    replies_ = means_.open_replies();
    if (!replies_) return;
    replies_->Latch(kKeptReplies);  // An asker may subscribe to the replies after the first one.
  }
  const TypeInfo& type = TypeOf<ControlReply>();
  PreparedMessage prepared;
  if (replies_->Reserve(reply.get(), type, prepared) == PublishStatus::kOk) {
    (void)replies_->Commit(reply, type, {}, std::move(prepared));
  }
}

}  // namespace hgros

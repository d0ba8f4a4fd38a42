#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <utility>

#include <hgros/SessionControl.pb.h>

#include "hgros/clock/time.hpp"
#include "hgros/session/session_control.hpp"
#include "hgros/session/session_parts.hpp"
#include "hgros/session/snapshot_message.hpp"
#include "session/control/control_desk.hpp"
#include "session/session_core.hpp"

namespace hgros {
namespace {

// Requests are repeated, because sessions connect one after the other. The pause grows.
constexpr auto kFirstRepetition = std::chrono::milliseconds(20);
constexpr auto kLongestPause = std::chrono::milliseconds(500);
constexpr std::size_t kQueue = 1024;
constexpr std::chrono::milliseconds kAnswersIn{200};
constexpr std::chrono::milliseconds kLookAgain{5};
constexpr const char* kTooOld =
    "Its version of HyperGraph ROS takes no requests over a connection on which it only publishes. Use a newer version "
    "there, or give this session a publisher endpoint to which it connects.";

// Shared with subscriptions, whose last callbacks may come later.
struct Answers {
  std::mutex mutex;
  std::condition_variable came;
  std::map<std::uint64_t, ControlAnswer> all;  // By session.
  std::size_t missing = 0;

  // Under the mutex, so that no thread misses it that is about to wait.
  void Wake() {
    const std::scoped_lock lock(mutex);
    came.notify_all();
  }
  void Take(const ControlReply& reply, std::uint64_t from) {
    const std::scoped_lock lock(mutex);
    const auto asked = all.find(from);
    if (asked == all.end() || std::exchange(asked->second.answered, true)) return;
    asked->second.refusal = reply.refusal();
    asked->second.done = reply.done();
    if (!reply.descriptor_set().empty()) {
      asked->second.schema = {reply.type(), Encoding::kProtobuf, reply.fingerprint(), reply.descriptor_set()};
    }
    --missing;
    came.notify_all();
  }
};

void Publish(SessionOutlet& outlet, const ControlRequest& request) {
  const auto message = std::make_shared<const ControlRequest>(request);
  const TypeInfo& type = TypeOf<ControlRequest>();
  PreparedMessage prepared;
  if (outlet.Reserve(message.get(), type, prepared) != PublishStatus::kOk) return;
  (void)outlet.Commit(message, type, {}, std::move(prepared));
}

// Sends the request to the sessions that do not get it through the outlet, each its own.
void SendOrders(SessionCore& core, const SessionOutlet& outlet, ControlRequest request, Answers& answers) {
  const std::vector<SessionId> reached = outlet.Subscribers();
  const std::vector<std::uint64_t> missing(request.sessions().begin(), request.sessions().end());
  for (const std::uint64_t session : missing) {
    request.clear_sessions();
    request.add_sessions(session);
    const bool too_old = std::ranges::find(reached, session, &SessionId::value) == reached.end() &&
                         core.SendOrder({session}, request.SerializeAsString()) == OrderWay::kTooOld;
    const std::scoped_lock lock(answers.mutex);
    ControlAnswer& answer = answers.all.at(session);
    if (!answer.answered) answer.refusal = too_old ? kTooOld : "";
  }
}

// kMessages: as a message, behind those that were published before. kAny: also in other ways, which may be faster.
enum class AskWay { kMessages, kAny };

void AskUntilAnswered(SessionCore& core, SessionOutlet& outlet, ControlRequest& request, Answers& answers, AskWay way,
                      std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(answers.mutex);
  std::chrono::nanoseconds pause = kFirstRepetition;
  while (answers.missing > 0 && std::chrono::steady_clock::now() < deadline) {
    request.clear_sessions();
    for (const auto& [session, answer] : answers.all) {
      if (!answer.answered) request.add_sessions(session);
    }
    lock.unlock();
    const std::size_t subscribers = outlet.subscriber_count();
    if (subscribers > 0) Publish(outlet, request);
    if (way == AskWay::kAny) SendOrders(core, outlet, request, answers);
    lock.lock();
    const auto more = [&] { return outlet.subscriber_count() > subscribers; };
    (void)answers.came.wait_until(lock, std::min(deadline, DeadlineIn(pause)),
                                  [&] { return answers.missing == 0 || more(); });
    // A new subscriber may not get the first message.
    pause = more() ? kFirstRepetition : std::min<std::chrono::nanoseconds>(2 * pause, kLongestPause);
  }
}

bool HasWaiting(const ChannelOutlet& outlet) {
  ChannelTraffic traffic;
  outlet.AddTo(traffic);
  return traffic.out.queued_bytes > 0;
}

std::vector<ControlAnswer> Ask(SessionCore& core, std::span<const SessionId> sessions, const ControlOrder& order,
                               AskWay way, std::chrono::steady_clock::time_point deadline) {
  ServicePlace& place = core.place();
  const auto answers = std::make_shared<Answers>();
  for (const SessionId one : sessions) answers->all[one.value].session = one;
  answers->missing = answers->all.size();
  ControlRequest request;
  request.set_number(RandomId());
  request.set_action(static_cast<ControlRequest::Action>(order.action));
  request.set_version(VersionOf(request.action()));
  request.set_channel(order.channel);
  request.set_level(static_cast<std::uint32_t>(order.level));

  const auto take = [answers, self = core.id().value, number = request.number()](const AnyMessage& message,
                                                                                 const MessageInfo& info) {
    const auto& reply = *static_cast<const ControlReply*>(message.get());
    if (reply.asker() == self && reply.number() == number) answers->Take(reply, info.id.publisher);
  };
  const Subscription replies = place.Listen(std::string(kControlRepliesChannel), TypeOf<ControlReply>(), take, kQueue);
  // Sessions of this host connect with those that subscribe to this.
  const Subscription snapshots = place.Listen(
      std::string(kSnapshotsChannel), TypeOf<Snapshot>(), [](const AnyMessage&, const MessageInfo&) {}, kQueue);
  const std::string channel(kControlChannel);
  const auto outlet =
      place.OpenOutlet(channel, TypeOf<ControlRequest>(), {[] {}, [answers] { answers->Wake(); }, [] { return true; }});
  AskUntilAnswered(core, *outlet, request, *answers, way, deadline);
  place.CloseOutlet(channel, outlet);
  std::vector<ControlAnswer> result;
  const std::scoped_lock lock(answers->mutex);
  for (const SessionId one : sessions) result.push_back(answers->all.at(one.value));
  return result;
}

}  // namespace

std::vector<ControlAnswer> AskSessions(Session& session, std::span<const SessionId> sessions, const ControlOrder& order,
                                       std::chrono::nanoseconds timeout) {
  SessionCore& core = SessionParts(session).core();
  const auto deadline = DeadlineIn(timeout);
  if (core.asking().Enter(deadline)) {  // The channel of requests is advertised once.
    const std::shared_ptr<OneAtATime> leaves(&core.asking(), [](OneAtATime* asking) { asking->Leave(); });
    return Ask(core, sessions, order, AskWay::kAny, deadline);
  }
  std::vector<ControlAnswer> unanswered;
  for (const SessionId one : sessions) unanswered.push_back({one});
  return unanswered;
}

// An answer is behind the messages that were sent before the question. So those that waited here then need another one.
// Some never answer, such as those with `control: off`. They are waited for while a lossless subscriber lacks
// something.
bool SessionParts::AwaitReceived(std::span<const std::string> channels,
                                 std::chrono::steady_clock::time_point deadline) {
  SessionCore& asker = core();
  for (;;) {
    bool waiting = false;
    std::vector<std::shared_ptr<ChannelOutlet>> outlets;
    std::vector<SessionId> subscribers;
    for (const std::string& channel : channels) {
      const auto outlet = asker.outbound_.Find(channel);
      if (!outlet) continue;
      outlets.push_back(outlet);
      waiting = waiting || HasWaiting(*outlet);
      for (const SessionId one : outlet->Subscribers()) {
        if (std::ranges::find(subscribers, one) == subscribers.end()) subscribers.push_back(one);
      }
    }
    bool answered = subscribers.empty();
    const auto answers_by = DeadlineIn(kAnswersIn);
    if (!subscribers.empty() && asker.asking().Enter(answers_by)) {
      const std::shared_ptr<OneAtATime> leaves(&asker.asking(), [](OneAtATime* asking) { asking->Leave(); });
      const auto answers =
          Ask(asker, subscribers, {ControlAction::kDescribe, channels.front()}, AskWay::kMessages, answers_by);
      answered = std::ranges::all_of(answers, &ControlAnswer::answered);
    }
    if (!waiting && (answered || std::ranges::none_of(outlets, &ChannelOutlet::HasUnfinished))) return true;
    if (std::chrono::steady_clock::now() > deadline) return false;
    (void)asker.changes_.WaitUntil(
        kLookAgain, [] { return false; }, [] { return false; });
  }
}

}  // namespace hgros

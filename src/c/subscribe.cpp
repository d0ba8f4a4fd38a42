#include "hgros/c/subscribe.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "c/executors.hpp"
#include "c/handles.hpp"
#include "c/raw.hpp"
#include "c/readable.hpp"
#include "hgros/base/thread_local.hpp"
#include "hgros/clock/time.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/session/session_parts.hpp"
#include "hgros/session/type_gate.hpp"

namespace hgros::c {

namespace {

using RawPtr = std::shared_ptr<const RawMessage>;

// Where the callback of a queue puts the message that this thread takes. Created before, because a message that has
// left the queue must not be lost for want of memory.
HGROS_THREAD_LOCAL hgros_message* taken_here = nullptr;

NodeOptions NodeOptionsOf(const hgros_subscribe_options& options, Executor executor) {
  NodeOptions node{std::string(TextOrNone(options.name)), {}, std::move(executor)};
  const auto bytes = options.keep_all_bytes == 0 ? Queue::kUnlimitedBytes : std::size_t{options.keep_all_bytes};
  if (options.keep_all > 0 && options.keep_last > 0) {
    throw InvalidArgument("Both keep_last and keep_all are set. Leave one of them 0.");
  }
  if (options.keep_all == 0 && options.keep_all_bytes > 0) {
    throw InvalidArgument("keep_all_bytes is set without keep_all. Set both, or leave both 0.");
  }
  if (options.keep_all > 0) node.queue = Queue::KeepAll(std::size_t{options.keep_all}, bytes);
  if (options.keep_last > 0) node.queue = Queue::KeepLast(std::size_t{options.keep_last});
  return node;
}

}  // namespace
}  // namespace hgros::c

namespace hgros::c {

// A subscription whose queue the session ends, so that its descriptor becomes readable.
class QueueEnd final : public Dependent {
 public:
  explicit QueueEnd(const std::shared_ptr<Subscription>& subscription) : subscription_(subscription) {}

  // Without a lock: borrowed bytes of messages that wait are let go, and their program may close the queue there.
  void Stop() noexcept override {
    if (const auto subscription = subscription_.lock()) subscription->Reset();
  }
  void End() override {}             // The session ends its subscriptions.
  void Leave() noexcept override {}  // Stop() came before.

 private:
  const std::weak_ptr<Subscription> subscription_;
};

}  // namespace hgros::c

struct hgros_subscription {
  std::shared_ptr<hgros::c::Life> life;
  std::shared_ptr<hgros::TypeGate> gate;
  const std::shared_ptr<hgros::Subscription> subscription = std::make_shared<hgros::Subscription>();
  std::shared_ptr<hgros::c::QueueEnd> queue_end;  // Null with a callback.
  int descriptor = -1;                            // A duplicate that lives as long as the handle.
  std::atomic<bool> ended{false};

  ~hgros_subscription() {
    subscription->Reset();
    if (descriptor >= 0) close(descriptor);
  }
};

namespace hgros::c {
namespace {

template <class F>
void Wire(hgros_subscription& made, Session& session, std::string_view channel, const hgros_subscribe_options& options,
          Executor executor, F callback) {
  const TypeInfo* const expected = options.schema == nullptr ? nullptr : &RunTimeType(*options.schema->schema);
  made.gate = std::make_shared<TypeGate>(expected);
  NodeOptions node = NodeOptionsOf(options, std::move(executor));
  const Invoke invoke = options.concurrent != 0 ? Invoke::kConcurrent : Invoke::kSerial;
  *made.subscription = SessionParts(session).Subscribe(
      channel, expected == nullptr ? AnyType() : *expected, invoke,
      EraseCallback<RawMessage>([gate = made.gate, callback](RawPtr raw, const MessageInfo& info) {
        if (gate->Passes(raw->schema)) callback(std::move(raw), info);
      }),
      std::move(node), kFromC);
}

hgros_status Take(hgros_subscription& queue, std::int64_t timeout_ns, hgros_message*& taken) {
  if (queue.descriptor < 0) throw InvalidArgument("The subscription has a callback. Open a queue to take messages.");
  const auto deadline = DeadlineIn(Timeout(timeout_ns));
  auto lease = std::make_unique<hgros_message>();
  for (;;) {
    if (queue.life->closed()) return Fail(HGROS_CLOSED, queue.life->why_closed());
    hgros_message* const outer = std::exchange(taken_here, lease.get());
    const std::size_t run = queue.subscription->RunWaiting();
    taken_here = outer;
    if (lease->raw) {
      CountLease();
      taken = lease.release();
      return HGROS_OK;
    }
    if (run > 0) continue;  // A message of another type.
    if (queue.ended.load(std::memory_order_acquire)) return Fail(HGROS_CLOSED, "The queue was closed before.");
    if (timeout_ns == 0 || !AwaitReadable(queue.descriptor, deadline)) {
      return Fail(HGROS_TIMED_OUT, "No message waits in the queue.");
    }
  }
}

}  // namespace
}  // namespace hgros::c

namespace c = hgros::c;

hgros_status hgros_subscribe(hgros_session* session, const char* channel, const hgros_subscribe_options* options,
                             hgros_message_callback callback, void* user, hgros_release release,
                             hgros_subscription** subscription) {
  return c::CreatingFor(c::CallbackOf{c::LifeOf(session), {}}, user, release, subscription,
                        [&](const std::shared_ptr<const c::User>& kept) {
                          hgros_session& on = c::Opened(session);
                          const std::string_view name = c::Text(channel, "channel");
                          if (callback == nullptr) c::RefuseNull("callback");
                          const hgros_subscribe_options chosen = c::OptionsFrom(options);
                          auto made = std::make_unique<hgros_subscription>();
                          made->life = on.life;
                          c::Wire(*made, *on.session, name, chosen, c::ExecutorOf(chosen.executor),
                                  [callback, kept, life = on.life](c::RawPtr raw, const hgros::MessageInfo& info) {
                                    const c::InCallback inside(life.get());
                                    const hgros_message message(std::move(raw), info);
                                    callback(kept->get(), &message);
                                  });
                          return made;
                        });
}

hgros_status hgros_subscribe_queue(hgros_session* session, const char* channel, const hgros_subscribe_options* options,
                                   hgros_subscription** subscription) {
  return c::Creating(subscription, [&] {
    hgros_session& on = c::Opened(session);
    const std::string_view name = c::Text(channel, "channel");
    const hgros_subscribe_options chosen = c::OptionsFrom(options);
    if (chosen.executor != 0) throw c::InvalidArgument("A queue has no executor. Leave it 0.");
    auto made = std::make_unique<hgros_subscription>();
    made->life = on.life;
    c::Wire(*made, *on.session, name, chosen, hgros::Executor::Polled(),
            [](c::RawPtr raw, const hgros::MessageInfo& info) { c::taken_here->Fill(std::move(raw), info); });
    made->descriptor = fcntl(made->subscription->descriptor(), F_DUPFD_CLOEXEC, 0);
    if (made->descriptor < 0) {
      throw hgros::Error("The system has no descriptor for the queue: " + std::generic_category().message(errno) + ".",
                         {}, "Raise the limit of open files (ulimit -n).");
    }
    made->queue_end = std::make_shared<c::QueueEnd>(made->subscription);
    on.life->Add(made->queue_end);
    return made;
  });
}

hgros_status hgros_queue_take(hgros_subscription* queue, int64_t timeout_ns, hgros_message** message) {
  if (message != nullptr) *message = nullptr;
  return c::Guarded(
      [&] { return c::Take(c::Given(queue, "queue"), timeout_ns, c::Given(message, "the place for the result")); });
}

int32_t hgros_queue_descriptor(const hgros_subscription* queue) { return queue == nullptr ? -1 : queue->descriptor; }

hgros_status hgros_subscription_get_stats(const hgros_subscription* subscription, hgros_subscription_stats* stats) {
  return c::Guarded([&] {
    const hgros_subscription& of = c::Given(subscription, "subscription");
    const hgros::NodeSnapshot now = of.subscription->stats();
    hgros_subscription_stats filled{};
    filled.received = now.received;
    filled.dropped = now.dropped;
    filled.run = now.run;
    filled.queued = now.queued;
    filled.mismatched = of.gate->mismatched();
    filled.queue_wait_p50_ns = now.queue_wait.Quantile(0.5);
    filled.queue_wait_p99_ns = now.queue_wait.Quantile(0.99);
    c::FillIn(stats, filled);
  });
}

void hgros_subscription_end(hgros_subscription* subscription) {
  if (subscription == nullptr) return;
  const c::InClose closes;
  subscription->ended.store(true, std::memory_order_release);
  (void)c::Guarded([&] { subscription->subscription->Reset(); });
}

void hgros_subscription_close(hgros_subscription* subscription) {
  const c::InClose closes;
  hgros_subscription_end(subscription);
  delete subscription;
}

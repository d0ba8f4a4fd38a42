#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "c/callbacks.hpp"
#include "c/calling.hpp"
#include "c/held.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/c/session.h"
#include "hgros/session/session.hpp"

namespace hgros::c {

// What the handles of a session share with it. They keep it alive; it does not keep the session.
//
// Thread safety: all functions.
class Life {
 public:
  explicit Life(Session& session) : session_(&session) {}

  // The session has ended, or this is a forked child: the locks here may be held by threads that it does not have.
  [[nodiscard]] bool closed() const noexcept { return closed_.load(std::memory_order_acquire) || fork_.IsChild(); }
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_.IsChild(); }
  [[nodiscard]] std::string_view why_closed() const noexcept { return fork_.IsChild() ? kOfParent : kSessionClosed; }
  [[nodiscard]] std::stop_token stop() const noexcept { return stop_.get_token(); }
  // Runs `use` with the session, which does not end meanwhile. `use` must not wait.
  template <class F>
  hgros_status Use(F&& use) {
    if (closed()) return Fail(HGROS_CLOSED, why_closed());
    const std::shared_lock lock(mutex_);
    if (session_ == nullptr) return Fail(HGROS_CLOSED, why_closed());
    return use(*session_);
  }
  void Add(const std::shared_ptr<Dependent>& dependent);
  // Wakes all that wait for the session, and refuses its further use. Does not wait.
  void Stop();
  // The session is about to be destroyed. `inside`: in one of its callbacks.
  void End(bool inside);

 private:
  const ForkGuard fork_;
  std::atomic<bool> closed_{false};
  std::stop_source stop_;
  std::shared_mutex mutex_;
  Session* session_;
  std::vector<std::weak_ptr<Dependent>> dependents_;
};

// Ends an object and destroys its handle. Not inside a callback or the release of its user data, for which the object
// may have to wait.
template <class T, class F>
hgros_status Closing(const Life* life, Held<T>& held, F&& destroy) {
  return Guarded([&] {
    if (InCallback::Of(&held) || (life != nullptr && InCallback::Of(life))) {
      return Fail(HGROS_WOULD_DEADLOCK, "This handle cannot be closed inside a callback. Close it on another thread.");
    }
    const InClose closes;
    held.End();
    destroy();
    return hgros_status{HGROS_OK};
  });
}

}  // namespace hgros::c

struct hgros_session {
  std::unique_ptr<hgros::Session> session;
  std::shared_ptr<hgros::c::Life> life;
};

namespace hgros::c {

// A session that can be used; throws otherwise.
inline hgros_session& Opened(hgros_session* session) {
  hgros_session& on = Given(session, "session");
  if (on.life->closed()) throw SessionClosed(on.life->why_closed());
  return on;
}
inline std::shared_ptr<const Life> LifeOf(const hgros_session* session) {
  return session == nullptr ? nullptr : session->life;
}
inline const hgros_session& Opened(const hgros_session* session) { return Opened(const_cast<hgros_session*>(session)); }

}  // namespace hgros::c

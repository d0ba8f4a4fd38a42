#include "hgros/session/default_session.hpp"

#include <atomic>
#include <mutex>

#include "hgros/base/error.hpp"

namespace hgros {
namespace {

struct Default {
  std::mutex mutex;
  std::unique_ptr<Session> session;
  std::atomic<Session*> current{nullptr};  // Equal to session.get(); read without the lock.
  std::vector<Subscription> subscriptions;
  std::vector<std::shared_ptr<const void>> users;
};

Default& TheDefault() {
  // Never destroyed: if a program forgets Shutdown, its session must not end after the state of its threads.
  static Default& one = *new Default;
  return one;
}

}  // namespace

void Init(Config config, SessionOptions options) {
  Default& one = TheDefault();
  const std::scoped_lock lock(one.mutex);
  if (one.session) throw Error("Init was called twice.", {}, "Call Shutdown first, or own a Session.");
  one.session = std::make_unique<Session>(std::move(config), std::move(options));
  one.current.store(one.session.get(), std::memory_order_release);
}

void Init(const std::vector<std::filesystem::path>& files, SessionOptions options) {
  Init(files.empty() ? Config::OfEnvironment() : Config::Load(files), std::move(options));
}

void Shutdown() {
  Default& one = TheDefault();
  std::vector<Subscription> subscriptions;
  std::vector<std::shared_ptr<const void>> users;
  std::unique_ptr<Session> session;
  {
    const std::scoped_lock lock(one.mutex);
    subscriptions.swap(one.subscriptions);
    users.swap(one.users);
    one.current.store(nullptr, std::memory_order_release);
    session = std::move(one.session);
  }
  // Callbacks that still publish find no session. The error is counted as an exception of the callback.
  subscriptions.clear();
  users.clear();
}

Session& DefaultSession() {
  Session* session = TheDefault().current.load(std::memory_order_acquire);
  if (session == nullptr) throw Error("There is no default session.", {}, "Call hgros::Init first.");
  return *session;
}

void KeepUntilShutdown(Subscription subscription) {
  Default& one = TheDefault();
  const std::scoped_lock lock(one.mutex);
  one.subscriptions.push_back(std::move(subscription));
}

void KeepUntilShutdown(std::shared_ptr<const void> user) {
  Default& one = TheDefault();
  const std::scoped_lock lock(one.mutex);
  one.users.push_back(std::move(user));
}

}  // namespace hgros

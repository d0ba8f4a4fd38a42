#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hgros/codec/block.hpp"
#include "hgros/graph/raw_publisher.hpp"
#include "hgros/graph/subscription.hpp"
#include "hgros/session/session.hpp"
#include "inbox.hpp"

namespace hgros::python {

/// Keeps a subscription and its inbox.
class SubscriptionHandle : public OfProcess {
 public:
  SubscriptionHandle(Subscription subscription, std::shared_ptr<Inbox> inbox)
      : inbox_(std::move(inbox)), subscription_(std::move(subscription)) {}
  SubscriptionHandle(const SubscriptionHandle&) = delete;
  SubscriptionHandle& operator=(const SubscriptionHandle&) = delete;
  ~SubscriptionHandle() { End(); }

  [[nodiscard]] Inbox& inbox() noexcept { return *inbox_; }
  /// Errors: throws Error in a forked child.
  [[nodiscard]] const Subscription& subscription() const {
    RefuseInChild();
    return subscription_;
  }
  /// Waits for a message that is being put into the inbox. Call it without the GIL. Does nothing in a forked child.
  void End();

 private:
  const std::shared_ptr<Inbox> inbox_;
  Subscription subscription_;
};

/// A session and what Python may do with it. Closing it is safe while other threads use it.
class SessionHandle : public OfProcess {
 public:
  SessionHandle(Config config, const std::string& name, std::shared_ptr<Inbox> log);

  /// The session. Errors: throws Error after Close(), and in a forked child.
  [[nodiscard]] std::shared_ptr<Session> Use() const;
  /// A session that Close() leaves to the thread that calls it, after waiting for this object.
  class Receiving {
   public:
    explicit Receiving(SessionHandle& handle);
    Receiving(const Receiving&) = delete;
    Receiving& operator=(const Receiving&) = delete;
    ~Receiving();
    /// Null after Close().
    [[nodiscard]] Session* session() const noexcept { return session_.get(); }
    /// Close() waits.
    [[nodiscard]] bool closing() const noexcept { return handle_.closing_.load(); }

   private:
    SessionHandle& handle_;
    std::shared_ptr<Session> session_;
  };
  /// Ends the session, or lets the last thread that uses it do that. Call it without the GIL.
  /// Does nothing in a forked child.
  void Close();
  [[nodiscard]] bool closed() const;

  [[nodiscard]] Owned<SubscriptionHandle> Subscribe(const std::string& channel, const std::shared_ptr<Inbox>& inbox,
                                                    const NodeOptions& options, const MessageSchema* type);

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<Session> session_;
  std::condition_variable left_;  // By a thread that receives.
  int receiving_ = 0;
  std::atomic<bool> closing_{false};
};

/// Publishes bytes, with the cause of the callback that runs on this thread. All functions throw Error in a forked
/// child.
class PublisherHandle : public OfProcess {
 public:
  /// Memory for a message; empty once there is no session any more.
  using Lender = std::function<std::unique_ptr<Block>(std::size_t size_bytes)>;

  /// `beside_others`: nodes that are not of Python may run in the publishing thread, and may wait for a callback of
  /// Python. So it must never have the GIL.
  PublisherHandle(Lender lend, RawPublisher publish, bool beside_others = false)
      : lend_(std::move(lend)), publish_(std::move(publish)), beside_others_(beside_others) {}

  [[nodiscard]] bool beside_others() const noexcept { return beside_others_; }

  /// Copies the bytes once, into memory that receivers read if there is such memory. Call it without the GIL if it may
  /// take long: with many bytes or a time to wait.
  [[nodiscard]] PublishStatus Publish(Bytes bytes, std::optional<std::chrono::steady_clock::time_point> deadline) const;
  [[nodiscard]] PublishStatus Publish(const Payload& data,
                                      std::optional<std::chrono::steady_clock::time_point> deadline) const;
  [[nodiscard]] Block Loan(std::size_t size_bytes) const;

 private:
  Lender lend_;
  RawPublisher publish_;
  bool beside_others_;
};

/// What this thread's callback in Python handles; empty outside callbacks.
inline thread_local Cause current_cause;

}  // namespace hgros::python

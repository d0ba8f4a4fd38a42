#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"
#include "hgros/clock/errand_thread.hpp"
#include "hgros/graph/invoke.hpp"
#include "hgros/graph/node_options.hpp"
#include "hgros/graph/subscription.hpp"
#include "hgros/internal/base/call_site.hpp"
#include "hgros/services/call_future.hpp"
#include "hgros/services/service.hpp"
#include "hgros/services/service_place.hpp"
#include "hgros/services/service_snapshot.hpp"

namespace hgros {

class CallState;
class CallTable;
class WaitingCallers;
class ServiceCaller;

/// A service to offer.
struct ServiceSetting {
  std::string name;
  const TypeInfo* request = nullptr;
  const TypeInfo* reply = nullptr;
  const TypeInfo* request_body = nullptr;  ///< The handler's argument type.
  const TypeInfo* reply_body = nullptr;    ///< The handler's result type.
  Invoke invoke = Invoke::kSerial;
  AnyHandler handler;
};

// The services that one session offers and calls.
//
// Thread safety: all functions. Invariants: calls into the place are made under place_mutex_ (shared), so that Close()
// waits for them; no user code runs under it. The services' own thread handles what transports report. It runs no user
// code either: a callback that waits for a reply could block the event that ends its wait.
class Services : public std::enable_shared_from_this<Services> {
 public:
  Services(ServicePlace& place, SessionId id, std::shared_ptr<Log> log);
  ~Services();
  Services(const Services&) = delete;
  Services& operator=(const Services&) = delete;

  // Throws Error.
  std::shared_ptr<ServiceHost> Serve(ServiceSetting setting, NodeOptions options, const CallSite& where);
  struct Request {
    const TypeInfo& request;
    const TypeInfo& reply;
    const TypeInfo& body_type;
    AnyMessage body;
    std::chrono::nanoseconds timeout;
    bool answers_inline = false;  // The callback runs on the thread that ends the call. It does not wait.
  };
  std::shared_ptr<PendingCall> Call(std::string_view name, Request request, AnyAnswer callback);

  // Events of the session. Called on threads of the transports.
  void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept;
  // The other session serves no longer what is served here from now on, but may still announce it for a while.
  void TakeFrom(SessionId other);
  void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view sentence) noexcept;
  void OnAnnouncements() noexcept;
  // Ends all calls and refuses requests. Call Close() afterwards.
  void Refuse();
  // Call it before the place is destroyed.
  void Close();

  // For hosts and clients.
  void With(const std::function<void(ServicePlace&)>& use);
  void Post(std::function<void()> errand);
  void PostAt(std::chrono::steady_clock::time_point when, std::function<void()> errand);
  // Waits until every client that is being wired at the time of the call is ready.
  void AwaitWiring() const;
  void EndCall(const CallMessage& reply, const std::string& service);
  void Forget(const ServiceHost& host);
  // Why no reply of the service has come from another session, as far as this session can know: nobody offers replies
  // here. Empty otherwise.
  [[nodiscard]] std::string WhyNoReply(const std::string& service);
  [[nodiscard]] std::vector<ServiceSnapshot> Snapshot() const;
  [[nodiscard]] std::shared_ptr<ServiceHost> HostOf(std::string_view name) const;
  [[nodiscard]] SessionId id() const noexcept { return id_; }
  // In a forked child, services and calls may neither be waited for nor destroyed.
  [[nodiscard]] const std::shared_ptr<const ForkGuard>& fork() const noexcept { return fork_; }
  [[nodiscard]] const std::shared_ptr<Log>& log() const noexcept { return log_; }
  [[nodiscard]] const std::shared_ptr<CallTable>& calls() const noexcept { return calls_; }
  [[nodiscard]] const std::shared_ptr<WaitingCallers>& waiting_callers() const noexcept { return waiting_callers_; }

 private:
  // Throws Error.
  [[nodiscard]] std::shared_ptr<ServiceCaller> ClientOf(std::string_view name, const Request& request);
  void Dispatch(const std::shared_ptr<CallState>& call, const Request& request);
  void OpenAnswers();
  [[nodiscard]] std::vector<std::shared_ptr<ServiceCaller>> Clients() const;
  [[nodiscard]] std::vector<std::shared_ptr<ServiceHost>> Hosts() const;
  void LookForSecondServers();
  // Under thread_mutex_. False if there is no thread, because the services end or none can be made.
  [[nodiscard]] bool MakeThread();

  const std::shared_ptr<const ForkGuard> fork_ = std::make_shared<const ForkGuard>();
  const SessionId id_;
  const std::shared_ptr<Log> log_;
  const std::shared_ptr<CallTable> calls_;
  const std::shared_ptr<WaitingCallers> waiting_callers_;

  std::shared_mutex place_mutex_;
  ServicePlace* place_;

  mutable std::shared_mutex mutex_;  // Guards the next five members.
  bool refusing_ = false;
  std::map<std::string, std::shared_ptr<ServiceHost>, std::less<>> hosts_;
  std::map<std::string, std::shared_ptr<ServiceCaller>, std::less<>> clients_;
  struct SecondServer {
    SessionId session{};
    std::chrono::steady_clock::time_point since{};
    bool said = false;
  };
  std::map<std::string, SecondServer> second_servers_;                     // By service.
  std::map<SessionId, std::chrono::steady_clock::time_point> taken_from_;  // Until when its announcements may be late.

  std::mutex thread_mutex_;
  bool thread_ended_ = false;
  std::optional<ErrandThread> thread_;

  mutable std::mutex wiring_mutex_;  // Held while a client or the node of answers is wired.
  Subscription answers_;
};

}  // namespace hgros

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

#include "hgros/session/snapshot.hpp"
#include "session/call_table.hpp"
#include "session/errand_thread.hpp"
#include "session/help_line.hpp"
#include "session/service_client.hpp"
#include "session/service_host.hpp"
#include "session/service_place.hpp"

namespace hgros {

// The services that one session offers and calls.
//
// Thread safety: all functions. Invariants: calls into the place are made under place_mutex_, shared, so that Close()
// waits for them; no user code runs there. The services' own thread, for what carriers report, runs no user code
// either, so that no callback that waits for a reply holds up what would end it.
class Services : public std::enable_shared_from_this<Services> {
 public:
  Services(ServicePlace& place, SessionId id, std::shared_ptr<Log> log);
  ~Services();
  Services(const Services&) = delete;
  Services& operator=(const Services&) = delete;

  // Throws Error.
  std::shared_ptr<ServiceHost> Serve(ServiceHost::Setting setting, NodeOptions options, const CallSite& where);
  struct Request {
    const TypeInfo& request;
    const TypeInfo& reply;
    const TypeInfo& body_type;
    AnyMessage body;
    std::chrono::nanoseconds timeout;
  };
  std::shared_ptr<PendingCall> Call(std::string_view name, Request request, AnyAnswer callback);

  // What the session hears. On carriers' threads.
  void OnPeerGone(const PeerInfo& peer, std::string_view reason) noexcept;
  void OnTypeMismatch(std::string_view channel, const PeerInfo& peer, std::string_view sentence) noexcept;
  void OnAnnouncements() noexcept;
  // Ends all calls, and refuses requests. Afterwards Close().
  void Refuse();
  // The place is about to end.
  void Close();

  // For hosts and clients.
  void With(const std::function<void(ServicePlace&)>& use);
  void Post(std::function<void()> errand);
  void PostAt(std::chrono::steady_clock::time_point when, std::function<void()> errand);
  // Returns when no client is being wired that was when this was called.
  void AwaitWiring() const;
  void EndCall(const CallMessage& reply, const std::string& service);
  void Forget(const ServiceHost& host);
  [[nodiscard]] std::vector<ServiceSnapshot> Snapshot() const;
  [[nodiscard]] std::shared_ptr<ServiceHost> HostOf(std::string_view name) const;
  [[nodiscard]] SessionId id() const noexcept { return id_; }
  [[nodiscard]] const std::shared_ptr<Log>& log() const noexcept { return log_; }
  [[nodiscard]] const std::shared_ptr<CallTable>& calls() const noexcept { return calls_; }
  [[nodiscard]] const std::shared_ptr<HelpLine>& helpers() const noexcept { return helpers_; }

 private:
  // Throws Error.
  [[nodiscard]] std::shared_ptr<ServiceClient> ClientOf(std::string_view name, const Request& request);
  void Dispatch(const std::shared_ptr<CallState>& call, const Request& request);
  void OpenAnswers();
  [[nodiscard]] std::vector<std::shared_ptr<ServiceClient>> Clients() const;
  [[nodiscard]] std::vector<std::shared_ptr<ServiceHost>> Hosts() const;
  void LookForSecondServers();

  const SessionId id_;
  const std::shared_ptr<Log> log_;
  const std::shared_ptr<CallTable> calls_ = std::make_shared<CallTable>();
  const std::shared_ptr<HelpLine> helpers_ = std::make_shared<HelpLine>();

  std::shared_mutex place_mutex_;
  ServicePlace* place_;

  mutable std::shared_mutex mutex_;  // Guards what follows.
  bool refusing_ = false;
  std::map<std::string, std::shared_ptr<ServiceHost>, std::less<>> hosts_;
  std::map<std::string, std::shared_ptr<ServiceClient>, std::less<>> clients_;
  std::map<std::string, std::uint64_t> said_twice_;  // Served names, and the session that serves them, too.

  std::mutex thread_mutex_;
  bool thread_ended_ = false;
  std::optional<ErrandThread> thread_;

  mutable std::mutex wiring_mutex_;  // One service or client at a time is made.
  Subscription answers_;
};

}  // namespace hgros

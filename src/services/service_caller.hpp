#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/graph/message_info.hpp"
#include "hgros/graph/session_outlet.hpp"
#include "hgros/graph/subscription.hpp"
#include "hgros/transport/transport.hpp"
#include "services/call_state.hpp"

namespace hgros {

class Services;

// The calls of this session to one service in other sessions. The servers are the sessions that subscribe to the
// request channel. Calls go to the server that was found first. While there is none, and discovery does not rule one
// out, calls wait here.
//
// Thread safety: all functions; Update(), OnPeerGone() and OnMisfit() on the services' thread only.
// Invariants: a call's server is set under mutex_ from servers_. When a server is removed from servers_, its calls are
// ended afterwards, so no call waits for a server that has left.
class ServiceCaller : public std::enable_shared_from_this<ServiceCaller> {
 public:
  ServiceCaller(std::string name, const TypeInfo& request, const TypeInfo& reply,
                const std::shared_ptr<Services>& services);

  // Wires it. Throws Error.
  void Start();
  void Send(const std::shared_ptr<CallState>& call);
  // Call it on a thread that waits for the call. If replies are usually quick, it receives for a short time itself:
  // sleeping and waking would take longer than the rest of the call.
  void AwaitQuickly(const CallState& call);
  // Tells the server that the call was cancelled and need not be started.
  void Withdraw(const CallState& call);
  // Passes waiting calls to `host`, which now serves the name in this session. Call it on a thread that may run user
  // code.
  void HandOver(ServiceHost& host);
  // Looks up the current servers, then sends or ends the waiting calls.
  void Update();
  void OnPeerGone(const PeerInfo& peer, const std::string& reason);
  void OnMisfit(std::string_view channel, SessionId peer, const std::string& sentence);
  // " Did you mean ...?" if a service has nearly the same name, otherwise an empty text. For calls without a server.
  [[nodiscard]] std::string Suggestion();

  // Whether a session serves it now.
  [[nodiscard]] bool HasServer() {
    const std::scoped_lock lock(mutex_);
    return !servers_.empty();
  }
  [[nodiscard]] std::shared_ptr<Services> services() const { return services_.lock(); }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] const TypeInfo& request() const noexcept { return request_; }
  [[nodiscard]] const TypeInfo& reply() const noexcept { return reply_; }

 private:
  // Null if it is not a reply.
  [[nodiscard]] AnyMessage AsCall(const AnyMessage& message) const;
  void OnReply(const CallMessage& reply, const MessageInfo& info);
  // Posts the call, and receives the reply at once if it is there already.
  [[nodiscard]] PublishStatus PostAndLook(const CallState& call, Services& services);
  // kFull if it must be tried again, also without a subscriber.
  [[nodiscard]] PublishStatus Post(const std::shared_ptr<const CallMessage>& message);
  void UpdateServers(Services& services);
  void SendWaiting(Services& services);
  void EndWithoutServer(Services& services);
  // After this time, a call that waits for a server is logged.
  static constexpr auto kTimeForServers = std::chrono::seconds(5);
  // Looks again until no call waits.
  void SayIfCallsWait(bool said);
  void EndWaiting(const CallEnd& end);
  void EndCallsTo(Services& services, SessionId server, const CallEnd& end);
  struct Server {
    SessionId id;
    PeerInfo info;
    std::chrono::steady_clock::time_point since = std::chrono::steady_clock::now();
  };
  // A server has ended the service, and may have begun to serve it again at once. Not all calls that were sent before
  // have reached it.
  struct Ended {
    SessionId server;
    std::uint64_t end;
  };
  void OnEnded(SessionId server);
  // Ends those that were sent before this end, after a delay, so that a more precise reason can come first: a type
  // mismatch, or the end of the session.
  void EndCallsSoon(Services& services, const Server& server, std::uint64_t end);
  // Says nothing if the second server of then is no longer the second.
  void SayIfTwoServe(std::chrono::steady_clock::time_point second);

  const std::string name_;
  const TypeInfo& request_;
  const TypeInfo& reply_;
  const std::weak_ptr<Services> services_;
  std::shared_ptr<SessionOutlet> outlet_;  // Written only by Start().
  Subscription replies_;                   // Written only by Start().

  std::atomic<std::int64_t> usual_ns_{0};  // Moving average of the time from a call to its reply.

  std::mutex mutex_;
  std::uint64_t ends_ = 0;       // How often a server has ended the service.
  std::vector<Ended> ended_;     // What Update() has not seen.
  std::vector<Server> servers_;  // In the order in which they were found.
  std::deque<std::shared_ptr<CallState>> waiting_;
  std::map<std::uint64_t, std::string> misfits_;  // Error texts of sessions whose types do not fit, by session id.
  std::chrono::steady_clock::time_point second_since_;  // When the second of servers_ was found; zero without it.
  bool says_waiting_ = false;                           // SayIfCallsWait() will be called.

  std::mutex suggestion_mutex_;
  std::string suggestion_;  // Guarded by suggestion_mutex_, like the next one.
  std::optional<std::chrono::steady_clock::time_point> suggested_at_;
};

}  // namespace hgros

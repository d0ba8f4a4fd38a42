#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
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

// The calls of this session to one service of other sessions. Its servers are the sessions that subscribe to the
// channel of its requests; calls go to the one that was there first. While there is none, and discovery does not rule
// one out, calls wait here.
//
// Thread safety: all functions; Update(), OnPeerGone() and OnMisfit() by the services' thread alone.
// Invariants: a call's server is set under mutex_ from servers_. The calls of a server that is taken out of servers_
// are ended after that, so that no call waits for a server that has left.
class ServiceClient : public std::enable_shared_from_this<ServiceClient> {
 public:
  ServiceClient(std::string name, const TypeInfo& request, const TypeInfo& reply,
                const std::shared_ptr<Services>& services);

  // Wires it. Throws Error.
  void Start();
  void Send(const std::shared_ptr<CallState>& call);
  // A thread waits for the call: if replies come soon as a rule it looks for this one itself, for a moment. Falling
  // asleep and being woken would take longer than all the rest.
  void AwaitQuickly(const CallState& call);
  // The call has been cancelled: its server need not begin it.
  void Withdraw(const CallState& call);
  // This session serves the name now: calls that wait go there. On a thread that may run user code.
  void HandOver(ServiceHost& host);
  // Finds the servers of now, and sends or ends the calls that wait.
  void Update();
  void OnPeerGone(const PeerInfo& peer, const std::string& reason);
  void OnMisfit(std::string_view channel, SessionId peer, const std::string& sentence);

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] const TypeInfo& request() const noexcept { return request_; }
  [[nodiscard]] const TypeInfo& reply() const noexcept { return reply_; }

 private:
  // Null: it is no reply.
  [[nodiscard]] AnyMessage AsCall(const AnyMessage& message) const;
  void OnReply(const CallMessage& reply, const MessageInfo& info);
  // Posts it, and takes the reply if that is there as soon.
  [[nodiscard]] bool PostAndLook(const CallState& call, Services& services);
  [[nodiscard]] bool Post(const std::shared_ptr<const CallMessage>& message);
  void UpdateServers(Services& services);
  void SendWaiting();
  void EndWithoutServer(Services& services);
  void EndWaiting(const CallEnd& end);
  void EndCallsTo(Services& services, SessionId server, const CallEnd& end);
  struct Server {
    SessionId id;
    PeerInfo info;
  };
  // Unless a better reason is told before: that its type does not fit, or that the session is gone.
  void EndCallsSoon(Services& services, const Server& server);
  void ReportTwo(Services& services, const std::vector<Server>& servers);

  const std::string name_;
  const TypeInfo& request_;
  const TypeInfo& reply_;
  const std::weak_ptr<Services> services_;
  std::shared_ptr<SessionOutlet> outlet_;  // Written by Start() alone.
  Subscription replies_;                   // Written by Start() alone.

  std::atomic<std::int64_t> usual_ns_{0};  // From a call to its reply, lately.

  std::mutex mutex_;
  std::vector<Server> servers_;
  std::deque<std::shared_ptr<CallState>> waiting_;
  std::map<std::uint64_t, std::string> misfits_;  // Sessions whose types do not fit, with what was said.
  bool said_two_ = false;
};

}  // namespace hgros

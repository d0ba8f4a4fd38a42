#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/graph/session_outlet.hpp"
#include "hgros/internal/codec/call_message.hpp"
#include "hgros/transport/channel_search.hpp"

namespace hgros {

// What this session knows about the ways of a service's replies.
struct ReplyWays {
  bool leave = true;        // A publisher endpoint lists them, or needs not.
  bool enter = true;        // A subscriber endpoint lists them, or needs not.
  std::size_t offered = 0;  // The number of sessions that offer this session replies.
};

// The interface that services need from their session. Implemented by the session's core.
//
// Thread safety: all functions from any thread, also from within inline callbacks. Wiring throws Error.
class ServicePlace {
 public:
  virtual ~ServicePlace() = default;
  // Calls `callback` with every message on the channel from other sessions, on the thread that delivers it.
  virtual Subscription Listen(const std::string& channel, const TypeInfo& type, AnyCallback callback,
                              std::size_t queue_depth) = 0;
  // An outlet for messages that go only to other sessions: no node of this session receives them.
  virtual std::shared_ptr<SessionOutlet> OpenOutlet(const std::string& channel, const TypeInfo& type,
                                                    OutletEvents events) = 0;
  virtual void CloseOutlet(const std::string& channel, const std::shared_ptr<SessionOutlet>& outlet) = 0;
  [[nodiscard]] virtual DataGraph& Graph() = 0;
  [[nodiscard]] virtual ChannelSearch Search(const std::string& channel) = 0;
  [[nodiscard]] virtual std::vector<PeerInfo> Peers() const = 0;
  // The time for which a peer that ended without a goodbye may still be among the peers.
  [[nodiscard]] virtual int LongestSilenceMs() const = 0;
  [[nodiscard]] virtual ReplyWays WaysOf(const std::string& service) const = 0;
  // The names of all services that this session and the sessions that it knows serve.
  [[nodiscard]] virtual std::vector<std::string> KnownServices() = 0;
  // Tells the program that `other` serves a service that already has a server.
  virtual void ReportServedTwice(const PeerInfo& other, std::string channel, std::string sentence) noexcept = 0;
  // Receives messages from sessions of this host on the calling thread; see Visit.
  virtual void Receive(const Visit& visit) noexcept = 0;
};

// Sends a request or a reply with its cause to the other session.
PublishStatus SendCall(SessionOutlet& outlet, const std::shared_ptr<const CallMessage>& call, const TypeInfo& type);

// The channels of a service.
[[nodiscard]] std::string RequestChannel(std::string_view service);
[[nodiscard]] std::string ReplyChannel(std::string_view service, SessionId caller);
[[nodiscard]] bool IsRequestChannel(std::string_view channel);
// True for the channels of replies. Only the services of a session can listen there, because the message type is
// theirs.
[[nodiscard]] bool IsReplyChannel(std::string_view channel);
// The channel inside the serving session whose node runs the handler.
[[nodiscard]] std::string TurnChannel(std::string_view service);
// Throws Error if a service cannot have that name.
void RequireServiceName(std::string_view service);

}  // namespace hgros

#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/log.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/graph/session_outlet.hpp"
#include "hgros/transport/channel_search.hpp"

namespace hgros {

// What the services of a session need of it. Implemented by the session's core.
//
// Thread safety: all functions from any thread, also from within inline callbacks. Wiring throws Error.
class ServicePlace {
 public:
  virtual ~ServicePlace() = default;
  // Every message on the channel from outside, on the thread that delivers it.
  virtual Subscription Listen(const std::string& channel, const TypeInfo& type, AnyCallback callback,
                              std::size_t queue_depth) = 0;
  // A way out for what no node of this session gets.
  virtual std::shared_ptr<SessionOutlet> OpenOutlet(const std::string& channel, const TypeInfo& type,
                                                    OutletEvents events) = 0;
  virtual void CloseOutlet(const std::string& channel, const std::shared_ptr<SessionOutlet>& outlet) = 0;
  [[nodiscard]] virtual DataGraph& Graph() = 0;
  [[nodiscard]] virtual ChannelSearch Search(const std::string& channel) = 0;
  [[nodiscard]] virtual std::vector<PeerInfo> Peers() const = 0;
  // Tells the program that `other` serves what is served already.
  virtual void ReportServedTwice(const PeerInfo& other, std::string channel, std::string sentence) noexcept = 0;
  // Reads what comes from this host; see Visit.
  virtual void Receive(const Visit& visit) noexcept = 0;
};

// The channels of a service.
[[nodiscard]] std::string RequestChannel(std::string_view service);
[[nodiscard]] std::string ReplyChannel(std::string_view service, SessionId caller);
// Nobody but a session's services can listen there: its type is theirs.
[[nodiscard]] bool IsReplyChannel(std::string_view channel);
// The node inside the serving session that runs the handler.
[[nodiscard]] std::string TurnChannel(std::string_view service);
// Throws Error if a service cannot have that name.
void RequireServiceName(std::string_view service);

}  // namespace hgros

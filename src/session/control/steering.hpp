#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hgros/clock/errand_thread.hpp"
#include "hgros/graph/data_graph.hpp"
#include "hgros/session/snapshot.hpp"
#include "session/control/control_desk.hpp"
#include "session/endpoint_lists.hpp"
#include "session/inbound_channels.hpp"
#include "session/outbound_channels.hpp"

namespace hgros {

// What other sessions may change in this one while it runs.
//
// Thread safety: all functions. Requests are carried out on a thread of their own, which exists from the first one on.
// Changes that wait for callbacks are made on the errand thread.
class Steering {
 public:
  // All outlive it.
  struct Means {
    SessionId self;
    std::shared_ptr<Log> log;
    DataGraph& graph;
    OutboundChannels& outbound;
    InboundChannels& inbound;
    std::function<std::vector<PeerInfo>()> peers;
    std::function<void(Way way, const std::string& channel)> list;  // Adds the channel to the lists of endpoints.
    OutboundChannels::Later later;                                  // Runs an errand on the errand thread.
  };
  Steering(NetworkBridge& bridge, Means means);

  // Takes no more requests. Call it before the bridge ends.
  void Close() { desk_.Close(); }
  // The same, and waits for the one that is carried out now.
  void End();
  // Adds what it counts, and why channels that the session uses do not leave or enter it: they are forbidden, or no
  // endpoint lists them. `steering`: of the session, if others may change it.
  static void AddTo(SessionSnapshot& snapshot, const std::optional<Steering>& steering, const Config& config,
                    bool has_domain, const std::vector<ChannelUse>& uses);

 private:
  [[nodiscard]] ControlDesk::Means MeansOfDesk();
  [[nodiscard]] bool Forbids(const std::string& channel) const;
  void Post(std::function<void()> errand);
  // Throws Error if it cannot be done; otherwise writes into the reply what was done.
  void Obey(const ControlRequest& request, ControlReply& reply);
  // Writes the type of a channel into the reply. Throws Error if it is not known.
  void Describe(const std::string& name, ControlReply& reply) const;
  [[nodiscard]] std::string ChangeChannel(const ControlRequest& request);
  // Returns what was done, or what will be done when callbacks in flight have returned.
  [[nodiscard]] std::string ForbidOrAllow(const std::string& channel, bool forbid);
  // On the errand thread. Returns whether messages on their way are lost.
  bool SetForbidden(const std::string& channel, bool forbid);
  [[nodiscard]] std::string SetLogLevel(std::uint32_t level);
  [[nodiscard]] std::string Stop();

  const Means means_;
  mutable std::mutex mutex_;
  std::set<std::string, std::less<>> forbidden_;  // Guarded by mutex_.
  std::mutex starting_;
  std::optional<ErrandThread> orders_;  // The thread for requests. Created under starting_.
  ControlDesk desk_;                    // Ends first.
};

}  // namespace hgros

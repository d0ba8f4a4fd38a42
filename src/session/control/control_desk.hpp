#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include <hgros/SessionControl.pb.h>

#include "hgros/base/ids.hpp"
#include "hgros/base/log.hpp"
#include "hgros/bridge/channel_outlet.hpp"
#include "hgros/internal/base/call_site.hpp"
#include "hgros/transport/transport.hpp"

namespace hgros {

class NetworkBridge;

inline constexpr std::string_view kControlChannel = "hgros/control";
inline constexpr std::string_view kControlRepliesChannel = "hgros/control/replies";
// The newest version. A request has the version in which its action came, so that older sessions obey it, too.
inline constexpr std::uint32_t kControlVersion = 2;
[[nodiscard]] inline std::uint32_t VersionOf(ControlRequest::Action action) noexcept {
  return action == ControlRequest::DESCRIBE ? 2 : 1;
}

// Throws Error if a program wants to subscribe to kControlChannel: the session has one subscriber there, its desk.
void RequireOtherThanRequests(std::string_view channel, const CallSite& where);

// Takes the requests of other sessions to change something in this one, and answers them. The channel of requests is
// not announced, because it would add an entry to the announcement of each session. So requests come only from sessions
// that are connected for another channel, such as the one of snapshots.
//
// Thread safety: all functions. Requests are carried out one at a time, on a thread that waits for no callback, so that
// a program whose callbacks hang can still be stopped.
class ControlDesk final : private InboundSink {
 public:
  struct Means {
    SessionId self;
    std::shared_ptr<Log> log;
    // The name of a session, for people.
    std::function<std::string(SessionId)> name_of;
    // Does what is asked, and writes into the reply what was done. Throws Error if it cannot be done.
    std::function<void(const ControlRequest& request, ControlReply& reply)> obey;
    std::function<std::shared_ptr<ChannelOutlet>()> open_replies;
    // Runs an errand on the thread for requests.
    std::function<void(std::function<void()>)> post;
  };
  ControlDesk(NetworkBridge& bridge, Means means);
  ControlDesk(const ControlDesk&) = delete;
  ControlDesk& operator=(const ControlDesk&) = delete;
  ~ControlDesk() override;

  // Takes no more requests, and forgets those that wait. Call it before the bridge ends.
  void Close();
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 private:
  struct Asked {
    SessionId by;
    bool trusted;
    std::string bytes;
  };
  Accepted Accept(InboundMessage&& message) noexcept override;
  void Run() noexcept override {}
  void OnFault(PacketFault /*fault*/, std::string_view /*what*/) noexcept override {}
  void OnPublishers(std::size_t /*count*/) noexcept override {}

  void Work();
  void Answer(const Asked& asked);
  [[nodiscard]] ControlReply ReplyTo(const Asked& asked, const ControlRequest& request);
  void CountRefused(SessionId by, const std::string& why);
  void Send(const std::shared_ptr<const ControlReply>& reply);

  const Means means_;
  std::atomic<std::uint64_t> refused_{0};
  std::mutex mutex_;
  std::deque<Asked> waiting_;  // Guarded by mutex_, as the next.
  std::size_t strangers_ = 0;  // Number of waiting requests that are not trusted.
  // Used on the thread for requests only.
  std::deque<std::shared_ptr<const ControlReply>> given_;  // The latest, for requests that come again.
  std::shared_ptr<ChannelOutlet> replies_;
  std::shared_ptr<const void> requests_;  // Destroyed first.
};

}  // namespace hgros

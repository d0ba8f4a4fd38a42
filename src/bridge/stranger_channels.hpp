#pragma once

#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "hgros/base/ids.hpp"
#include "hgros/bridge/transport_list.hpp"

namespace hgros {

/// What sessions of this host announce that are not connected with this one. It finds the sessions that announce one
/// channel without a look at other channels, so thousands of channels are wired in linear time.
///
/// Thread safety: all functions.
class StrangerChannels {
 public:
  /// How a session announces one channel.
  struct Use {
    SessionId session;
    bool publishes = false;
    bool subscribes = false;
    TransportSet transports;
  };

  /// `uses`: by channel. Replaces what the session has announced before.
  void Remember(SessionId session, std::vector<std::pair<std::string, Use>>&& uses) {
    const std::scoped_lock lock(mutex_);
    ForgetLocked(session);
    std::vector<std::string>& channels = channels_[session];
    channels.reserve(uses.size());
    for (auto& [channel, use] : uses) {
      uses_[channel].push_back(use);
      channels.push_back(std::move(channel));
    }
  }

  void Forget(SessionId session) {
    const std::scoped_lock lock(mutex_);
    ForgetLocked(session);
  }

  [[nodiscard]] std::vector<Use> UsesOf(const std::string& channel) const {
    const std::scoped_lock lock(mutex_);
    const auto uses = uses_.find(channel);
    return uses == uses_.end() ? std::vector<Use>() : uses->second;
  }

 private:
  void ForgetLocked(SessionId session) {
    const auto known = channels_.find(session);
    if (known == channels_.end()) return;
    for (const std::string& channel : known->second) {
      const auto uses = uses_.find(channel);
      if (uses == uses_.end()) continue;  // It was announced twice.
      std::erase_if(uses->second, [&](const Use& use) { return use.session == session; });
      if (uses->second.empty()) uses_.erase(uses);
    }
    channels_.erase(known);
  }

  mutable std::mutex mutex_;
  std::unordered_map<std::string, std::vector<Use>> uses_;            // By channel.
  std::unordered_map<SessionId, std::vector<std::string>> channels_;  // Of each session, to forget them.
};

}  // namespace hgros

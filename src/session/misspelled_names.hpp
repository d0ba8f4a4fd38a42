#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hgros/base/ids.hpp"
#include "hgros/base/log.hpp"
#include "hgros/bridge/channel_directory.hpp"
#include "hgros/config/config.hpp"
#include "hgros/graph/data_graph.hpp"

namespace hgros {

// Reports names of channels that are probably misspelled: in the configuration, and those of channels that nobody uses
// at the other end. Each one is reported once.
//
// Thread safety: all functions. None is called under a lock of the session.
class MisspelledNames {
 public:
  using Clock = std::chrono::steady_clock;
  struct Means {
    const DataGraph& graph;
    std::shared_ptr<Log> log;
    std::function<SessionChannels()> own;              // The channels of this session.
    std::function<std::vector<KnownChannel>()> known;  // The channels of all sessions that it knows.
    // Whether this session is connected with another end of its channel, for example with a plain program.
    std::function<bool(const std::string& channel)> connected;
    std::function<void(std::chrono::nanoseconds delay, std::function<void()> errand)> later;
  };
  explicit MisspelledNames(Means means) : means_(std::move(means)) {}

  // Whether the configuration names channels.
  [[nodiscard]] static bool AreIn(const Config& config);
  // Reports channels of the configuration that the session has not used so far.
  void SayUnused(const Config& config);
  // A channel of this session is open to others. If it has no other end after 5 s and after 30 s, when these had time
  // to start, and another one of nearly the same name has none either, this is reported.
  void Note(const std::string& channel, Clock::time_point now = Clock::now());
  // Looks at the channels that are due. Returns after what time it must be called again, if it must.
  [[nodiscard]] std::optional<std::chrono::nanoseconds> LookForOtherEnds(Clock::time_point now);

 private:
  // A channel to look for.
  struct Due {
    std::string channel;
    bool again = false;  // The first look found no other end.
  };
  void LookIn(std::chrono::nanoseconds delay);
  [[nodiscard]] bool HasSubscribers(const KnownChannel& channel) const;
  void SayIfAlone(const std::string& channel, const std::vector<KnownChannel>& known, SessionId self) const;
  [[nodiscard]] bool IsPublishedHere(const std::string& channel) const;

  const Means means_;
  std::mutex mutex_;
  std::set<std::string> said_;  // What SayUnused() has reported. Guarded by mutex_, like the rest.
  std::set<std::string> noted_;
  bool looks_ = false;  // LookForOtherEnds() will be called.
  std::multimap<Clock::time_point, Due> due_;
};

}  // namespace hgros

#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "discovery/bell.hpp"
#include "discovery/folder_watch.hpp"
#include "discovery/own_announcement.hpp"
#include "discovery/peer_book.hpp"
#include "discovery/registry_folder.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"

namespace hgros::discovery {

/// The registry's thread and what it knows. It waits for the folder's news and for the bell; it has a deadline only
/// while something is in doubt or waits to be written.
///
/// Thread safety: Announce(), List() and in_forked_child().
class RegistryCore {
 public:
  RegistryCore(const RegistryOptions& options, DiscoveryListener& listener, Log& log);
  RegistryCore(const RegistryCore&) = delete;
  RegistryCore& operator=(const RegistryCore&) = delete;
  ~RegistryCore();

  void Announce(const Announcement& own);
  [[nodiscard]] std::vector<Announcement> List() const { return book_.List(); }
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_.IsChild(); }

 private:
  using Clock = std::chrono::steady_clock;
  using Event = FolderWatch::Event;
  /// A session of which it is not clear whether it still lives: looked at again, ever less often, and then no more.
  struct Doubt {
    Clock::time_point next_look;
    std::chrono::milliseconds pause;
    bool removed;  // Its file, while it lived; otherwise somebody has closed it.
  };

  void Loop();
  [[nodiscard]] std::optional<Clock::time_point> Deadline() const;
  void Open();
  void Mend();
  void Scan();
  void Examine(const std::string& name, std::optional<Event> event);
  void ExamineAbsent(const std::string& name, SessionId session, std::optional<Event> event);
  void ExamineAlive(const std::string& name, SessionId session, const std::string& content);
  void LookAgain();
  void SayOnce(const std::string& name, const std::string& fault);

  DiscoveryListener& listener_;
  Log& log_;
  const ForkGuard fork_;
  const RegistryFolder folder_;
  OwnAnnouncement own_;
  PeerBook book_;
  FolderWatch watch_;                           // Of the thread, as what follows.
  std::map<std::string, Doubt> doubts_;         // By name.
  std::map<std::string, std::string> strange_;  // Names and what was said about them.
  std::optional<Clock::time_point> next_mending_;
  Bell bell_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace hgros::discovery

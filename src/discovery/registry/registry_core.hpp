#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <vector>

#include "discovery/peer_book.hpp"
#include "discovery/registry/folder_watch.hpp"
#include "discovery/registry/own_announcement.hpp"
#include "discovery/registry/registry_folder.hpp"
#include "discovery/registry/session_file.hpp"
#include "discovery/wake_event.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/log.hpp"

namespace hgros::discovery {

/// The registry's thread and state. It waits for events of the folder and for a signal; it has a deadline only while
/// the state of a session is uncertain or a write is due, and as root, which looks for sessions of others.
///
/// Thread safety: Announce(), List() and in_forked_child().
class RegistryCore {
 public:
  RegistryCore(const RegistryOptions& options, DiscoveryListener& listener, Log& log);
  RegistryCore(const RegistryCore&) = delete;
  RegistryCore& operator=(const RegistryCore&) = delete;
  ~RegistryCore();

  void Announce(const Announcement& own);
  [[nodiscard]] std::vector<Announcement> List(const Discovery::Which& which) const { return book_.List(which); }
  [[nodiscard]] bool in_forked_child() const noexcept { return fork_.IsChild(); }

 private:
  using Clock = std::chrono::steady_clock;
  using Event = FolderWatch::Event;
  /// A session that may have died. It is checked again at growing intervals, and finally no longer.
  struct Doubt {
    Clock::time_point next_look;
    std::chrono::milliseconds pause;
    bool removed;  // Its file was removed while it lived; otherwise the file was closed.
  };

  void Loop();
  [[nodiscard]] std::optional<Clock::time_point> Deadline() const;
  void Open();
  void Mend();
  void Scan(bool deaths);
  void ExamineAll(const std::vector<FolderWatch::FileEvent>& events);
  void Examine(const std::string& name, std::optional<Event> event);
  void SayBlind();  // This process can open no more files. Tries again later.
  void ExamineAbsent(const std::string& name, SessionId session, std::optional<Event> event);
  void ExamineAlive(const std::string& name, SessionId session, const FileLook& look);
  void Forget(const std::string& name, SessionId session, std::string_view reason);
  void LookElsewhere();
  void PlanLookElsewhere();
  void LookAgain();
  void SayOnce(const std::string& name, const std::string& fault);

  DiscoveryListener& listener_;
  Log& log_;
  const ForkGuard fork_;
  const RegistryFolder folder_;
  OwnAnnouncement own_;
  PeerBook book_;
  FolderWatch watch_;                                // Only the thread uses it and the members below.
  std::map<std::string, Doubt> doubts_;              // By name.
  std::unordered_map<std::string, FileStamp> read_;  // The files whose content is in `book_`.
  Clock::time_point next_look_elsewhere_{};          // Once the session is announced.
  Clock::duration between_looks_elsewhere_;
  std::set<std::filesystem::path> said_elsewhere_;
  std::map<std::string, std::string> strange_;  // Names and the faults that were logged for them.
  std::optional<Clock::time_point> next_mending_;
  WakeEvent wake_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace hgros::discovery

#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/log.hpp"
#include "hgros/discovery/discovery.hpp"
#include "hgros/discovery/registry.hpp"
#include "support/await.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::discovery {

/// Keeps all calls, and notes where the contract of DiscoveryListener is broken.
class Listening final : public DiscoveryListener {
 public:
  void OnCame(const Announcement& peer) override {
    const std::scoped_lock lock(mutex_);
    if (!here_.emplace(peer.session, peer).second) broken_ = "came twice";
    ++came_[peer.session];
    if (on_came) on_came();
  }
  void OnChanged(const Announcement& peer) override {
    const std::scoped_lock lock(mutex_);
    const auto entry = here_.find(peer.session);
    if (entry == here_.end()) {
      broken_ = "changed without having come";
      return;
    }
    if (entry->second == peer) broken_ = "changed without a change";
    entry->second = peer;
  }
  void OnGone(const Announcement& last, std::string_view reason) override {
    const std::scoped_lock lock(mutex_);
    const auto entry = here_.find(last.session);
    if (entry == here_.end() || entry->second != last) broken_ = "gone as another than it was";
    if (entry != here_.end()) here_.erase(entry);
    gone_[last.session] = reason;
  }

  /// Runs at the end of each OnCame; set before the first one.
  std::function<void()> on_came;

  [[nodiscard]] std::vector<Announcement> here() const {
    const std::scoped_lock lock(mutex_);
    std::vector<Announcement> all;
    for (const auto& [session, peer] : here_) all.push_back(peer);
    return all;
  }
  [[nodiscard]] bool Sees(const Announcement& peer) const {
    const std::scoped_lock lock(mutex_);
    const auto entry = here_.find(peer.session);
    return entry != here_.end() && entry->second == peer;
  }
  [[nodiscard]] bool AwaitPeer(const Announcement& peer) const {
    return test::Await([&] { return Sees(peer); });
  }
  [[nodiscard]] bool AwaitCount(std::size_t count) const {
    return test::Await([&] { return here().size() == count; });
  }
  /// How many times the session came.
  [[nodiscard]] int came(SessionId session) const {
    const std::scoped_lock lock(mutex_);
    const auto entry = came_.find(session);
    return entry == came_.end() ? 0 : entry->second;
  }
  /// The reason why it went; empty if it did not.
  [[nodiscard]] std::string gone(SessionId session) const {
    const std::scoped_lock lock(mutex_);
    const auto entry = gone_.find(session);
    return entry == gone_.end() ? std::string() : entry->second;
  }
  /// The calls that broke the contract; empty if there were none.
  [[nodiscard]] std::string broken() const {
    const std::scoped_lock lock(mutex_);
    return broken_;
  }

 private:
  mutable std::mutex mutex_;
  std::map<SessionId, Announcement> here_;
  std::map<SessionId, int> came_;
  std::map<SessionId, std::string> gone_;
  std::string broken_;
};

/// A log that keeps its lines.
class KeptLog {
 public:
  Log log{[this](LogLevel, std::string_view text) {
    const std::scoped_lock lock(mutex_);
    lines_.emplace_back(text);
  }};

  /// Number of lines that contain all of `words`.
  [[nodiscard]] std::size_t Count(const std::vector<std::string>& words) const {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::size_t>(std::ranges::count_if(lines_, [&](const std::string& line) {
      return std::ranges::all_of(words, [&](const std::string& word) { return line.find(word) != line.npos; });
    }));
  }
  [[nodiscard]] std::string text() const {
    const std::scoped_lock lock(mutex_);
    std::string all;
    for (const std::string& line : lines_) all += line + "\n";
    return all;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> lines_;
};

/// The folder of a domain that nobody else uses. It does not exist yet.
struct OwnDomain {
  test::ScratchFolder scratch;
  RegistryOptions options{scratch / "hgros", "robot"};
  std::filesystem::path folder = options.folder / options.domain;
};

/// True if `folder` is empty or missing. A registry that closes removes an empty folder, and others create it again.
inline bool IsEmptyOrGone(const std::filesystem::path& folder) {
  std::error_code gone;
  return std::filesystem::directory_iterator(folder, gone) == std::filesystem::directory_iterator();
}

inline Announcement NewAnnouncement(const std::string& process = "test") {
  Announcement own = AnnouncementOfThisProcess(SessionId::Random(), 1);
  own.process = process;
  own.places = {{"shared_memory", "/run/place of memory"}, {"loop", "over there"}};
  own.endpoints = {"ipc:///run/bus", "tcp://127.0.0.1:5555"};
  own.channels = {{ChannelUse{"scan", "foxglove.LaserScan", Encoding::kProtobuf, 17, true, false, false},
                   std::vector<std::string>{"zmq"}},
                  {ChannelUse{"robot1/pose", "Pose", Encoding::kPlain, 18, false, true, true},
                   std::vector<std::string>{"loop", "shared_memory"}}};
  own.only = {"test", "a viewer"};
  return own;
}

/// A session that takes part in discovery.
struct Participant {
  using Opening = std::function<std::unique_ptr<Discovery>(DiscoveryListener& listener, Log& log)>;
  explicit Participant(const Opening& open, const std::string& process = "test")
      : own(NewAnnouncement(process)), discovery(open(listening, log.log)) {}
  ~Participant() {
    discovery.reset();
    EXPECT_EQ(listening.broken(), "");
  }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  void Announce() const { discovery->Announce(own); }

  KeptLog log;
  Listening listening;
  Announcement own;
  std::unique_ptr<Discovery> discovery;
};

/// The exit status of a forked child that ends `discovery`: 0 if it lists nothing there and refuses to announce.
inline int UseInForkedChild(std::unique_ptr<Discovery>& discovery, const Announcement& own) {
  (void)std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    int status = discovery->List().empty() ? 0 : 1;
    try {
      discovery->Announce(own);
      status |= 2;
    } catch (const Error&) {
    }
    discovery.reset();
    _exit(status);
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace hgros::discovery

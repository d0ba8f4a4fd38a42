// Several sessions of one process that use the same channels, for tests of many sessions on one host. Each subscribes
// to "tf" and "clock". Writes its counters to standard output: "status name=number ...", and the
// lines of the sessions' logs that are no debug lines: "log ...". It ends in order on SIGTERM, and is killed when its
// parent ends.
//
//   --sessions=N         number of sessions
//   --publishers=N       number of sessions that also publish "tf", ten times a second
//   --total=N            number of all sessions; a session that knows all does not count them again
//   --every=N            writes the counters every N tenths of a second; 1 if it is missing
//   --inotify=N          in a user namespace of its own with a limit of N inotify instances
//   --network=apart      in a network namespace of its own
//   --disk=full          with a registry on a file system of its own, which is full for the first second
//   --files=N            the limit of open files, set after half a second
#include <dirent.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <foxglove/Log.pb.h>

#include "hgros/hgros.hpp"
#include "resilience/worker_program.hpp"

namespace hgros::resilience {
namespace {

using Message = foxglove::Log;

constexpr const char* kDisk = "/mnt";

std::atomic<std::uint64_t> lines{0};  // Of all sessions, at the default level.

/// One session and what it has seen.
class Member {
 public:
  explicit Member(bool publishes)
      : session_(Config(), SessionOptions{"member", [](LogLevel level, std::string_view text) {
                                            if (level == LogLevel::kDebug) return;
                                            ++lines;
                                            Say("log " + std::string(text));
                                          }}) {
    tf_ = session_.FromAny<Message>("tf", Invoke::kSerial, [this](const Message& /*message*/) { ++received; });
    clock_ = session_.FromAny<Message>("clock", Invoke::kSerial, [](const Message& /*message*/) {});
    if (publishes) publish_.emplace(session_.Advertise<Message>("tf"));
  }
  void Publish() const {
    if (publish_) (*publish_)(std::make_unique<Message>());
  }
  /// The number of sessions that it knows to subscribe to "tf", itself included. Not counted again once it was `total`.
  [[nodiscard]] std::uint64_t Known(std::uint64_t total) {
    if (total > 0 && known_ >= total) return known_;
    for (const KnownChannel& channel : session_.Channels()) {
      if (channel.name == "tf") return known_ = channel.subscribers.size();
    }
    return 0;
  }
  [[nodiscard]] std::uint64_t Peers() const { return session_.Peers().size(); }

  std::atomic<std::uint64_t> received{0};

 private:
  std::uint64_t known_ = 0;
  Session session_;
  Subscription tf_;
  Subscription clock_;
  std::optional<Publisher<Message>> publish_;
};

void WriteTo(const std::string& path, const std::string& text) {
  if (!(std::ofstream(path) << text << std::flush)) throw std::runtime_error("cannot write to " + path);
}

void Enter(int namespaces) {
  const std::string user = std::to_string(geteuid());
  const std::string group = std::to_string(getegid());
  if (unshare(namespaces) != 0) throw std::runtime_error("no namespaces");
  WriteTo("/proc/self/setgroups", "deny");
  WriteTo("/proc/self/uid_map", user + " " + user + " 1");
  WriteTo("/proc/self/gid_map", group + " " + group + " 1");
}

std::uint64_t OpenFiles() {
  std::uint64_t count = 0;
  DIR* const folder = opendir("/proc/self/fd");
  if (folder == nullptr) return 0;  // The limit is reached.
  while (readdir(folder) != nullptr) ++count;
  closedir(folder);
  return count - 3;  // ".", "..", and the folder itself.
}

int Run(const Arguments& arguments, const sigset_t& end) {
  if (const std::string most = arguments.Text("inotify"); !most.empty()) {
    Enter(CLONE_NEWUSER);
    WriteTo("/proc/sys/user/max_inotify_instances", most);
  }
  if (arguments.Text("network") == "apart") Enter(CLONE_NEWUSER | CLONE_NEWNET);
  const bool full_disk = arguments.Text("disk") == "full";
  if (full_disk) {
    Enter(CLONE_NEWUSER | CLONE_NEWNS);
    // An inode for the root, and for each of the two folders of the registry.
    if (mount("tmpfs", kDisk, "tmpfs", 0, "mode=0700,nr_inodes=3") != 0) throw std::runtime_error("cannot mount");
    setenv("XDG_RUNTIME_DIR", kDisk, 1);
  }
  std::vector<std::unique_ptr<Member>> members;
  for (std::uint64_t i = 0; i < arguments.Number("sessions"); ++i) {
    members.push_back(std::make_unique<Member>(i < arguments.Number("publishers")));
  }
  const std::uint64_t every = arguments.Number("every", 1);
  const timespec period{0, 100'000'000};
  int signal = 0;
  for (std::uint64_t round = 0; signal <= 0; ++round) {
    for (const auto& member : members) member->Publish();
    if (const std::uint64_t files = arguments.Number("files"); files > 0 && round == 5) {
      const rlimit limit{files, files};
      setrlimit(RLIMIT_NOFILE, &limit);
    }
    if (full_disk && round == 10 && mount(nullptr, kDisk, nullptr, MS_REMOUNT, "nr_inodes=1000") != 0) {
      throw std::runtime_error("cannot make room");
    }
    if (round % every == 0) {
      std::uint64_t known = ~0ULL, received = ~0ULL, peers = 0;
      for (const auto& member : members) {
        known = std::min(known, member->Known(arguments.Number("total")));
        peers = std::max(peers, member->Peers());
        received = std::min<std::uint64_t>(received, member->received);
      }
      Say("status ready=1 known=" + std::to_string(known) + " received=" + std::to_string(received) +
          " peers=" + std::to_string(peers) + " lines=" + std::to_string(lines) +
          " files=" + std::to_string(OpenFiles() / members.size()));
    }
    signal = sigtimedwait(&end, nullptr, &period);
  }
  members.clear();
  Say("status ended=1 lines=" + std::to_string(lines));
  return 0;
}

}  // namespace
}  // namespace hgros::resilience

int main(int count, char** texts) { return hgros::resilience::RunWorker(count, texts, hgros::resilience::Run); }

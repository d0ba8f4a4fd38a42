#include "hgros/params/param_file_watch.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/own_descriptor.hpp"
#include "hgros/base/system_limits.hpp"
#include "params/watched_files.hpp"

namespace hgros {
namespace {

using Steady = std::chrono::steady_clock;
constexpr auto kNever = Steady::time_point::max();

// Between the first sign that a path leads elsewhere and a reload: what replaces a folder or a link in several steps is
// complete by then.
constexpr auto kTimeToReplace = std::chrono::milliseconds(100);

}  // namespace

class ParamFileWatch::Core {
 public:
  const ForkGuard fork;  // A child has none of the threads.
  Core(ParamServer& server, Done done, LogSink log)
      : server_(server), done_(std::move(done)), log_(std::move(log)), files_(server_.files()), end_([] {
          return eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
        }) {
    if (!end_) {
      throw Error(std::string("Parameter files cannot be watched: ") + std::strerror(errno) + ".", "",
                  "Raise the limit of open files (ulimit -n).");
    }
    files_.LookUp();
    // Reads changes that were written after the server read the files and before the watch began. Done here and not on
    // the thread: by then somebody may be writing again. A file that is half written is read when it is closed.
    const ParamNodePtr before = server_.Snapshot().node();
    if (const ParamResult result = Reload(files_.Targets()); !result.ok() || server_.Snapshot().node() != before) {
      Say(result);
    }
    thread_ = StartThread<std::thread>("the thread that watches parameter files", [this] { Loop(); });
  }
  Core(const Core&) = delete;
  Core& operator=(const Core&) = delete;
  ~Core() {
    const std::uint64_t one = 1;
    (void)!write(end_.get(), &one, sizeof one);
    thread_.join();
  }

 private:
  void Loop() {
    std::array<pollfd, 2> descriptors{pollfd{files_.fd(), POLLIN, 0}, pollfd{end_.get(), POLLIN, 0}};
    for (;;) {
      const auto rest = std::chrono::ceil<std::chrono::milliseconds>(due_ - Steady::now());
      const int wait_ms = due_ == kNever ? -1 : std::max(0, static_cast<int>(rest.count()));
      if (poll(descriptors.data(), descriptors.size(), wait_ms) < 0) {
        if (errno == EINTR) continue;
        return;
      }
      if (descriptors[1].revents != 0) return;
      if (TakeNews() == WatchedFiles::News::kWritten) written_ = true;
      if (due_ == kNever) continue;
      std::vector<WatchedFiles::Target> targets = files_.Targets();
      if (Steady::now() < due_ && (!written_ || !AreComplete(targets))) continue;
      const bool changed = written_ || AreOthers(targets);
      due_ = kNever;
      written_ = false;
      if (!changed) continue;
      const std::string emptied = NameOfEmptied(targets);
      if (emptied.empty()) {
        waited_ = false;
        Say(Reload(std::move(targets)));
      } else if (std::exchange(waited_, !waited_)) {
        Say({emptied + " is empty, as after a save that failed. Write {} into it if it is to have no values."});
      } else {
        due_ = Steady::now() + kTimeToReplace;  // Somebody may be about to write it.
      }
    }
  }

  // The file that had content when it was read, and has none now.
  [[nodiscard]] std::string NameOfEmptied(const std::vector<WatchedFiles::Target>& targets) const {
    for (std::size_t i = 0; i < targets.size(); ++i) {
      const bool now = targets[i].error == 0 && targets[i].size_bytes == 0;
      if (now && read_[i].error == 0 && read_[i].size_bytes > 0) return server_.files()[i].string();
    }
    return {};
  }

  ParamResult Reload(std::vector<WatchedFiles::Target> targets) {
    read_ = std::move(targets);
    ParamResult result = server_.Reload();
    // What changed during the reload was read or not, even if the targets are the same again.
    if (TakeNews() != WatchedFiles::News::kNone) written_ = true;
    return result;
  }

  WatchedFiles::News TakeNews() {
    const WatchedFiles::News news = files_.Read();
    if (news == WatchedFiles::News::kNone) return news;
    if (due_ == kNever) due_ = Steady::now() + kTimeToReplace;
    try {
      files_.LookUp();
    } catch (const Error& e) {
      log_.WriteLimited(LogLevel::kWarning, "watch", e.what());
    }
    return news;
  }

  static bool AreComplete(const std::vector<WatchedFiles::Target>& targets) {
    return std::all_of(targets.begin(), targets.end(),
                       [](const WatchedFiles::Target& target) { return target.error == 0 && !target.open; });
  }

  // Whether there is another file than the one that was read. One that is open is read when it is closed.
  bool AreOthers(const std::vector<WatchedFiles::Target>& targets) const {
    for (std::size_t i = 0; i < targets.size(); ++i) {
      if (!targets[i].open && targets[i] != read_[i]) return true;
    }
    return false;
  }

  void Say(const ParamResult& result) {
    if (!done_) {
      if (!result.ok()) log_.Write(LogLevel::kWarning, "The parameters keep their old values: " + result.refusal);
      return;
    }
    try {
      done_(result);
    } catch (const std::exception& e) {
      log_.Write(LogLevel::kError, std::string("The callback for reloaded parameters threw: ") + e.what());
    } catch (const ForcedUnwind&) {
      EndAfterForcedUnwind(log_, "The callback for reloaded parameters");
    } catch (...) {
      log_.Write(LogLevel::kError,
                 "The callback for reloaded parameters threw something that is not a std::exception.");
    }
  }

  ParamServer& server_;
  const Done done_;
  Log log_;
  WatchedFiles files_;
  OwnDescriptor end_;
  std::vector<WatchedFiles::Target> read_;  // By the last reload.
  Steady::time_point due_ = kNever;         // Something changed; the reload is due then.
  bool written_ = false;                    // Since the last reload.
  bool waited_ = false;                     // For the content of an empty file.
  std::thread thread_;
};

ParamFileWatch::ParamFileWatch(ParamServer& server, Done done, LogSink log)
    : core_(std::make_unique<Core>(server, std::move(done), std::move(log))) {}
ParamFileWatch::~ParamFileWatch() {
  if (core_->fork.IsChild()) LeaveToParent(std::shared_ptr<const Core>(std::move(core_)));
}

}  // namespace hgros

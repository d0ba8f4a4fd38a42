#include "hgros/params/param_file_watch.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "hgros/base/forced_unwind.hpp"
#include "hgros/base/fork_guard.hpp"
#include "hgros/base/own_descriptor.hpp"
#include "hgros/base/system_limits.hpp"

namespace hgros {

// Watches folders instead of files, because editors replace the old file with a new one.
class ParamFileWatch::Core {
 public:
  const ForkGuard fork;  // A child has none of the threads.
  Core(ParamServer& server, Done done, LogSink log)
      : server_(server),
        done_(std::move(done)),
        log_(std::move(log)),
        inotify_([] { return inotify_init1(IN_NONBLOCK | IN_CLOEXEC); }),
        end_([] { return eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC); }) {
    if (!inotify_ || !end_) Fail("");
    for (const std::filesystem::path& file : server_.files()) {
      WatchName(std::filesystem::absolute(file));
      std::error_code fault;
      const std::filesystem::path target = std::filesystem::canonical(file, fault);
      if (!fault) WatchName(target);
    }
    // Reads changes that were written after the server read the files and before the watch began. Done here and not on
    // the thread: by then somebody may be writing again. A file that is half written is read when it is closed.
    const ParamNodePtr read = server_.Snapshot().node();
    if (const ParamResult result = server_.Reload(); !result.ok() || server_.Snapshot().node() != read) Say(result);
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
  [[noreturn]] static void Fail(const std::string& folder) {
    throw Error(
        std::string("Parameter files cannot be watched: ") + std::strerror(errno) + ".", folder,
        "Raise fs.inotify.max_user_instances or max_user_watches (sysctl), or the limit of open files (ulimit -n).");
  }

  void WatchName(const std::filesystem::path& file) {
    const std::filesystem::path folder = file.parent_path();
    const int watch = inotify_add_watch(inotify_.get(), folder.c_str(), IN_CLOSE_WRITE | IN_MOVED_TO | IN_ONLYDIR);
    if (watch < 0) Fail(folder.string());
    names_[watch].insert(file.filename().string());
  }

  void Loop() {
    std::array<pollfd, 2> descriptors{pollfd{inotify_.get(), POLLIN, 0}, pollfd{end_.get(), POLLIN, 0}};
    for (;;) {
      if (poll(descriptors.data(), descriptors.size(), -1) < 0) {
        if (errno == EINTR) continue;
        return;
      }
      if (descriptors[1].revents != 0) return;
      if (ReadNews()) Say(server_.Reload());
    }
  }

  // Reads all pending events. True if one of them is about one of the files.
  bool ReadNews() {
    bool ours = false;
    alignas(inotify_event) std::array<char, 16 * 1024> buffer{};
    for (;;) {
      const ssize_t size = read(inotify_.get(), buffer.data(), buffer.size());
      if (size < 0 && errno == EINTR) continue;
      if (size <= 0) return ours;
      for (ssize_t at = 0; at < size;) {
        inotify_event event{};
        std::memcpy(&event, buffer.data() + at, sizeof event);
        const char* const name = buffer.data() + at + sizeof event;
        at += static_cast<ssize_t>(sizeof event + event.len);
        if ((event.mask & IN_Q_OVERFLOW) != 0) ours = true;
        const auto names = names_.find(event.wd);
        if (event.len > 0 && names != names_.end() && names->second.contains(name)) ours = true;
      }
    }
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
  OwnDescriptor inotify_;
  OwnDescriptor end_;
  std::map<int, std::set<std::string, std::less<>>> names_;  // by watch
  std::thread thread_;
};

ParamFileWatch::ParamFileWatch(ParamServer& server, Done done, LogSink log)
    : core_(std::make_unique<Core>(server, std::move(done), std::move(log))) {}
ParamFileWatch::~ParamFileWatch() {
  if (core_->fork.IsChild()) LeaveToParent(std::shared_ptr<const Core>(std::move(core_)));
}

}  // namespace hgros

#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

namespace hgros::discovery {

/// A discovery_worker that has announced its sessions. Killed when this object ends.
class AnnouncingProcess {
 public:
  AnnouncingProcess(const std::filesystem::path& folder, const std::string& domain, int sessions, bool forks = false);
  AnnouncingProcess(const AnnouncingProcess&) = delete;
  AnnouncingProcess& operator=(const AnnouncingProcess&) = delete;
  ~AnnouncingProcess();

  /// Sends SIGKILL and does not wait.
  void Kill() const;
  /// Ends it, and a child that it forked, in order, and waits. Returns the exit status, or -1.
  int Finish();
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] pid_t child() const { return child_; }

 private:
  pid_t pid_ = -1;
  pid_t child_ = 0;
  int input_ = -1;  // Closing it ends the worker.
};

}  // namespace hgros::discovery

#pragma once

#include <filesystem>
#include <string>
#include <utility>

namespace hgros::cli {

/// A control group (cgroup, version 2) for a process and all that it starts, also what leaves its process group or
/// session. Where the system has none that this user may use, it is empty and does nothing.
class ControlGroup {
 public:
  /// Below the group of this process. `name` must be free.
  explicit ControlGroup(const std::string& name);
  /// Kills what is in it, and removes it.
  ~ControlGroup();
  ControlGroup(const ControlGroup&) = delete;
  ControlGroup& operator=(const ControlGroup&) = delete;

  /// This process moves to the group. After a fork, it may be called in the child.
  void Join() const noexcept;
  void Kill() const noexcept;
  /// Kills and removes all whose names begin so, below the group of this process.
  static void EndAll(const std::string& begin);

 private:
  explicit ControlGroup(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
};

}  // namespace hgros::cli

#include "processes/control_group.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>

namespace hgros::cli {
namespace {

constexpr int kPatienceMs = 100;  // For what was killed to leave the group.

// The folder of this process's group; empty: there is none.
std::filesystem::path OwnFolder() {
  std::string group;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (line.starts_with("0::/")) group = line.substr(4);
  }
  std::ifstream mounts("/proc/self/mountinfo");
  for (std::string line; std::getline(mounts, line);) {
    if (line.find(" - cgroup2 ") == std::string::npos) continue;
    std::istringstream fields(line);
    std::string skipped;
    std::string root;
    std::string point;
    fields >> skipped >> skipped >> skipped >> root >> point;
    const std::filesystem::path below = std::filesystem::path("/" + group).lexically_relative(root);
    if (!below.empty() && *below.begin() != "..") return std::filesystem::path(point) / below;
  }
  return {};
}

void WriteTo(const std::filesystem::path& file, std::string_view text) noexcept {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  (void)!write(descriptor, text.data(), text.size());
  (void)close(descriptor);
}

void AwaitEmpty(const std::filesystem::path& folder) {
  const int events = open((folder / "cgroup.events").c_str(), O_RDONLY | O_CLOEXEC);
  if (events < 0) return;
  pollfd changed{events, POLLPRI, 0};
  do {
    std::array<char, 128> text{};
    const ssize_t size = pread(events, text.data(), text.size(), 0);
    if (size <= 0 || std::string_view(text.data(), static_cast<std::size_t>(size)).starts_with("populated 0")) break;
  } while (poll(&changed, 1, kPatienceMs) > 0);
  (void)close(events);
}

}  // namespace

ControlGroup::ControlGroup(const std::string& name) {
  const std::filesystem::path own = OwnFolder();
  if (own.empty()) return;
  const std::filesystem::path folder = own / name;
  std::error_code error;
  if (!std::filesystem::create_directory(folder, error)) return;
  if (access((folder / "cgroup.kill").c_str(), W_OK) == 0) {
    folder_ = folder;
  } else {
    (void)std::filesystem::remove(folder, error);
  }
}

ControlGroup::~ControlGroup() {
  if (folder_.empty()) return;
  Kill();
  AwaitEmpty(folder_);
  std::error_code error;
  (void)std::filesystem::remove(folder_, error);
}

void ControlGroup::Join() const noexcept {
  if (!folder_.empty()) WriteTo(folder_ / "cgroup.procs", "0");
}

void ControlGroup::EndAll(const std::string& begin) {
  const std::filesystem::path own = OwnFolder();
  std::error_code error;
  for (std::filesystem::directory_iterator at(own, error), end; !error && at != end; at.increment(error)) {
    if (at->path().filename().string().starts_with(begin)) const ControlGroup ends(at->path());
  }
}

void ControlGroup::Kill() const noexcept {
  if (!folder_.empty()) WriteTo(folder_ / "cgroup.kill", "1");
}

}  // namespace hgros::cli

#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "hgros/base/ids.hpp"

/// The files in a registry's folder. The rules that everyone keeps, whatever version:
///  1. A session's file is named by its id. It is written under another name, a dot before it, locked (an exclusive OFD
///     lock), and then renamed: whoever sees a session's file sees all of it, and locked.
///  2. The owner holds the lock as long as the file is valid; the kernel releases it when the owner dies.
///  3. Nobody removes or replaces a name without holding the lock of the file that it names. So a file whose lock
///     somebody else can take is stale, and whoever takes it may remove it.
///  4. A file under its first name may be found unlocked, and removed, before its owner has locked it. The owner looks
///     whether it is still there once it has the lock.
///  5. Closing a file that was open for writing wakes all who watch the folder (IN_CLOSE_WRITE), also when the kernel
///     does it for a dead process. So a mere look opens for reading only.
namespace hgros::discovery {

/// The session whose file bears that name; none if it is another's.
[[nodiscard]] SessionId SessionOfFile(std::string_view name) noexcept;
/// Whether a file bears the name that it has before it is complete.
[[nodiscard]] bool IsUnfinished(std::string_view name) noexcept;
[[nodiscard]] std::string FileName(SessionId session);
[[nodiscard]] std::string UnfinishedFileName(SessionId session);

/// Takes the lock of an open file; errno otherwise.
[[nodiscard]] bool TakeLock(int fd) noexcept;

struct FileLook {
  enum class State {
    kAbsent,
    kAlive,    ///< Its owner lives; `content` is what it says.
    kStale,    ///< Its owner is dead.
    kStrange,  ///< Nothing to trust: `fault` says why.
  };
  State state = State::kAbsent;
  std::string content;
  std::string fault;
  bool operator==(const FileLook&) const = default;
};

[[nodiscard]] FileLook LookAtFile(const std::filesystem::path& path);

/// Removes the file if it is stale still.
void RemoveStaleFile(const std::filesystem::path& path);

}  // namespace hgros::discovery

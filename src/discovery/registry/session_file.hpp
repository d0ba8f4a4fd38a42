#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/ids.hpp"

/// The files in a registry's folder. All versions of the library keep these rules:
///  1. A session's file is named by its id. It is written under another name, starting with a dot, locked (an exclusive
///     OFD lock) and then renamed: every process that sees the file sees all of it, and locked.
///  2. The owner holds the lock as long as the file is valid; the kernel releases it when the owner dies.
///  3. A name is removed or replaced only by a process that holds the lock of its file. So a file that another process
///     can lock is stale, and that process may remove it.
///  4. A file under its first name can be found unlocked, and removed, before its owner has locked it. After locking,
///     the owner checks that it is still there.
///  5. Closing a file that was open for writing wakes all watchers of the folder (IN_CLOSE_WRITE), also when the kernel
///     closes it for a dead process. So a process that only reads opens the file for reading only.
namespace hgros::discovery {

/// The session in a file name; zero if it is not the name of a session's file.
[[nodiscard]] SessionId SessionOfFile(std::string_view name) noexcept;
/// Whether a name is that of a file that is not complete yet.
[[nodiscard]] bool IsUnfinished(std::string_view name) noexcept;
[[nodiscard]] std::string FileName(SessionId session);
[[nodiscard]] std::string UnfinishedFileName(SessionId session);

/// Locks an open file; sets errno on failure.
[[nodiscard]] bool TakeLock(int fd) noexcept;

/// Tells one content of a session's file from another: each content is in a file of its own.
struct FileStamp {
  std::uint64_t inode = 0;  ///< 0: no file.
  std::int64_t modified_ns = 0;
  std::int64_t size_bytes = 0;
  bool operator==(const FileStamp&) const = default;
};

/// The names in a folder, and their stamps, without opening the files. No names if the folder cannot be read; nullopt
/// if that is because this process can open no more files.
[[nodiscard]] std::optional<std::vector<std::pair<std::string, FileStamp>>> FilesIn(
    const std::filesystem::path& folder);

struct FileLook {
  enum class State {
    kAbsent,
    kAlive,    ///< The owner lives; `content` is its announcement.
    kAsKnown,  ///< The owner lives, and the file is the known one, which is not read again.
    kStale,    ///< The owner is dead.
    kStrange,  ///< Not trusted: `fault` says why.
    kUnknown,  ///< This process can open no more files.
  };
  State state = State::kAbsent;
  std::string content;
  std::string fault;
  FileStamp stamp = {};
};

/// `known`: the stamp of the file that was read before.
[[nodiscard]] FileLook LookAtFile(const std::filesystem::path& path, const FileStamp& known = {});

/// Whether a process holds the lock of a session's file in `folder`, whatever user it belongs to.
[[nodiscard]] bool HoldsSessions(const std::filesystem::path& folder) noexcept;

/// Removes the file if it is still stale.
void RemoveStaleFile(const std::filesystem::path& path);

}  // namespace hgros::discovery

#include "discovery/registry/stale_folders.hpp"

#include <unistd.h>

#include <optional>
#include <system_error>
#include <vector>

#include "discovery/registry/registry_folder.hpp"
#include "discovery/registry/session_file.hpp"
#include "hgros/discovery/domain.hpp"

namespace hgros::discovery {
namespace {

namespace fs = std::filesystem;

// The entries of the folder; none if it cannot be read.
std::optional<std::vector<fs::path>> Entries(const fs::path& folder) {
  std::error_code fault;
  std::vector<fs::path> entries;
  for (fs::directory_iterator entry(folder, fault), end; !fault && entry != end; entry.increment(fault)) {
    entries.push_back(entry->path());
  }
  return fault ? std::nullopt : std::optional(std::move(entries));
}

bool IsDeadSessions(const fs::path& file) {
  const std::string name = file.filename().string();
  return (SessionOfFile(name).value != 0 || IsUnfinished(name)) && LookAtFile(file).state == FileLook::State::kStale;
}

void RemoveIfStale(const fs::path& folder) {
  if (!IsDomain(folder.filename().string()) || !FolderFault(folder).empty()) return;
  const auto files = Entries(folder);
  if (!files || files->empty()) return;  // A session may be starting.
  for (const fs::path& file : *files) {
    if (!IsDeadSessions(file)) return;  // Its own sessions clean up.
  }
  for (const fs::path& file : *files) RemoveStaleFile(file);
  rmdir(folder.c_str());  // Fails if a session has started meanwhile; one that is starting creates it again.
}

}  // namespace

void RemoveStaleFolders(const fs::path& own) noexcept {
  try {
    const auto folders = Entries(own.parent_path());
    if (!folders) return;
    for (const fs::path& folder : *folders) {
      if (folder != own) RemoveIfStale(folder);
    }
  } catch (const std::exception&) {
    return;  // No memory: the next registry does it.
  }
}

}  // namespace hgros::discovery

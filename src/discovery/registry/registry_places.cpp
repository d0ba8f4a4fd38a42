#include "discovery/registry/registry_places.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <string_view>
#include <system_error>

#include "discovery/registry/session_file.hpp"
#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kOthersMayWrite = S_IWGRP | S_IWOTH;
constexpr mode_t kForThisUser = 0700;
constexpr int kMostNames = 1000;  // Other users may take some.
constexpr std::string_view kLink = ".place-";
constexpr auto kFresh = std::chrono::seconds(10);

fs::path InTemporary(const fs::path& temporary, const std::string& user) { return temporary / ("hgros-" + user); }

bool CanUse(const fs::path& folder) {
  return folder.is_absolute() && FolderFault(folder).empty() && access(folder.c_str(), W_OK) == 0;
}

// One folder may have several paths: /var/run is often a link to /run.
bool IsSameFolder(const fs::path& one, const fs::path& other) {
  std::error_code fault;  // One of them does not exist.
  return one == other || fs::equivalent(one, other, fault);
}

// Sessions in different network namespaces cannot share memory, so they do not follow each other's links.
std::string LinksOfThisNetwork() {
  struct stat status {};
  return std::string(kLink) + std::to_string(stat("/proc/self/ns/net", &status) == 0 ? status.st_ino : 0) + "-";
}

std::vector<fs::path> EntriesOf(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code fault;
  for (fs::directory_iterator entry(folder, fault), end; !fault && entry != end; entry.increment(fault)) {
    entries.push_back(entry->path());
  }
  return entries;
}

bool HoldsSessionsOfAnyDomain(const fs::path& place) {
  return std::ranges::any_of(EntriesOf(place), [](const fs::path& domain) { return HoldsSessions(domain); });
}

// Whether the session that made the link may not have announced itself yet.
bool IsFresh(const fs::path& link) {
  struct stat status {};
  return lstat(link.c_str(), &status) == 0 && std::chrono::seconds(std::time(nullptr) - status.st_mtim.tv_sec) < kFresh;
}

}  // namespace

std::string FolderFault(const fs::path& path) {
  struct stat status {};
  // Does not follow a symbolic link: any user may have put one into /tmp.
  if (lstat(path.c_str(), &status) != 0) return std::string("it cannot be read: ") + std::strerror(errno);
  if (!S_ISDIR(status.st_mode)) return S_ISLNK(status.st_mode) ? "it is a symbolic link" : "it is not a folder";
  if (status.st_uid != geteuid()) {
    return "it belongs to user " + std::to_string(status.st_uid) + ", and this is user " + std::to_string(geteuid());
  }
  if ((status.st_mode & kOthersMayWrite) != 0) return "others may write to it";
  return {};
}

RegistryPlaces::Roots RegistryPlaces::Roots::OfThisProcess() {
  Roots roots;
  if (const char* const runtime = std::getenv("XDG_RUNTIME_DIR")) roots.runtime = runtime;
  return roots;
}

// The first name that belongs to this user, or is free. A session that sees the same names chooses the same one.
std::optional<fs::path> RegistryPlaces::Temporary() const {
  const fs::path first = InTemporary(roots_.temporary, std::to_string(geteuid()));
  for (int number = 0; number < kMostNames; ++number) {
    const fs::path path = number == 0 ? first : fs::path(first.string() + "-" + std::to_string(number));
    if (mkdir(path.c_str(), kForThisUser) != 0 && errno != EEXIST) return std::nullopt;
    if (CanUse(path)) return path;
  }
  return std::nullopt;
}

std::vector<fs::path> RegistryPlaces::All() const {
  std::vector<fs::path> all;
  const auto add = [&](const fs::path& place) {
    if (std::ranges::find(all, place) == all.end()) all.push_back(place);
  };
  if (CanUse(roots_.runtime)) add((roots_.runtime / "hgros").lexically_normal());
  if (const fs::path own = roots_.users / std::to_string(geteuid()); CanUse(own)) add(own / "hgros");
  const auto temporary = Temporary();
  if (!temporary) return all;
  add(*temporary);
  const std::string link = LinksOfThisNetwork();
  for (const fs::path& entry : EntriesOf(*temporary)) {
    if (!entry.filename().string().starts_with(link)) continue;
    std::error_code fault;
    const fs::path target = fs::read_symlink(entry, fault);
    if (!fault && CanUse(target)) add(target);
  }
  return all;
}

// Also those of other networks: their sessions may have been killed, and their network may be gone.
void RegistryPlaces::RemoveStaleLinks() const {
  const auto temporary = Temporary();
  if (!temporary) return;
  for (const fs::path& entry : EntriesOf(*temporary)) {
    if (!entry.filename().string().starts_with(kLink) || IsFresh(entry)) continue;
    std::error_code fault;
    const fs::path target = fs::read_symlink(entry, fault);
    if (!fault && !HoldsSessionsOfAnyDomain(target)) unlink(entry.c_str());
  }
}

fs::path RegistryPlaces::Choose(const std::string& domain) const {
  const std::vector<fs::path> all = All();
  if (all.empty()) {
    const fs::path temporary = InTemporary(roots_.temporary, std::to_string(geteuid()));
    throw Error("There is no folder in which sessions could find each other.", temporary.string(),
                "Let this user write to " + roots_.temporary.string() +
                    ", or set XDG_RUNTIME_DIR to a folder to which only this user may write.");
  }
  const auto joins = std::ranges::find_if(all, [&](const fs::path& place) { return HoldsSessions(place / domain); });
  const fs::path chosen = joins == all.end() ? all.front() : *joins;
  (void)mkdir(chosen.c_str(), kForThisUser);  // Others follow a link only to a folder that exists.
  Link(chosen);
  RemoveStaleLinks();
  return chosen;
}

void RegistryPlaces::Link(const fs::path& chosen) const {
  if (chosen.parent_path() == roots_.users / std::to_string(geteuid())) return;
  const auto temporary = Temporary();
  if (!temporary || chosen == *temporary) return;
  const std::string name = LinksOfThisNetwork() + std::to_string(std::hash<std::string>()(chosen.string()));
  const fs::path link = *temporary / name;
  if (symlink(chosen.c_str(), link.c_str()) != 0) utimensat(AT_FDCWD, link.c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
}

std::vector<RegistryPlaces::Elsewhere> RegistryPlaces::FindElsewhere(const fs::path& chosen,
                                                                     const std::string& domain) const {
  std::vector<Elsewhere> elsewhere;
  const auto look = [&](const fs::path& place, uid_t user) {
    if (!IsSameFolder(place, chosen) && HoldsSessions(place / domain)) elsewhere.push_back({place / domain, user});
  };
  for (const fs::path& place : All()) look(place, geteuid());
  if (geteuid() != 0) return elsewhere;  // Others' folders cannot be read.
  std::vector<fs::path> of_others;
  for (const fs::path& entry : EntriesOf(roots_.users)) of_others.push_back(entry / "hgros");
  for (const fs::path& entry : EntriesOf(roots_.temporary)) {
    if (entry.filename().string().starts_with("hgros-")) of_others.push_back(entry);
  }
  for (const fs::path& place : of_others) {
    struct stat status {};
    const bool others = lstat(place.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid != 0;
    if (others) look(place, status.st_uid);
  }
  return elsewhere;
}

}  // namespace hgros::discovery

#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hgros::discovery {

/// Why this user's sessions cannot trust the folder `path`; empty if they can.
[[nodiscard]] std::string FolderFault(const std::filesystem::path& path);

/// The folders in which sessions of this user may find each other. Programs of one user get different environments
/// from a login, cron and systemd, so each session looks into all of them and joins the sessions that are there.
///
/// In this order: $XDG_RUNTIME_DIR/hgros, /run/user/UID/hgros, and /tmp/hgros-UID. The folder in /tmp has a number at
/// its end if another user has taken the name. It also has links, ".place-...", to folders that only some programs
/// know from their environment. A link is removed once no session lives in its folder.
class RegistryPlaces {
 public:
  /// The folders above those of the users.
  struct Roots {
    std::filesystem::path runtime;              ///< $XDG_RUNTIME_DIR; may be empty.
    std::filesystem::path users = "/run/user";  ///< Has a folder for each user that is logged in.
    std::filesystem::path temporary = "/tmp";
    [[nodiscard]] static Roots OfThisProcess();
  };
  explicit RegistryPlaces(Roots roots) : roots_(std::move(roots)) {}

  /// The folder for the sessions of `domain`: the first in which such sessions live, otherwise the first that can be
  /// used. Leaves a link to it, if others could not know it. Throws Error if none can be used.
  [[nodiscard]] std::filesystem::path Choose(const std::string& domain) const;

  /// A folder with living sessions that those in another one do not find.
  struct Elsewhere {
    std::filesystem::path folder;
    uid_t user = 0;
  };
  /// Sessions of `domain` that live in other folders than `chosen`: of this user, and (for root) of others.
  [[nodiscard]] std::vector<Elsewhere> FindElsewhere(const std::filesystem::path& chosen,
                                                     const std::string& domain) const;

  /// Leaves or renews the link to the chosen folder, if others could not know it. To be called before a session is
  /// announced there: a new link stays for some seconds without one.
  void Link(const std::filesystem::path& chosen) const;
  /// Removes the links to folders in which no session lives.
  void RemoveStaleLinks() const;

 private:
  [[nodiscard]] std::vector<std::filesystem::path> All() const;
  [[nodiscard]] std::optional<std::filesystem::path> Temporary() const;

  const Roots roots_;
};

}  // namespace hgros::discovery

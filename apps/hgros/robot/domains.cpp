#include "robot/domains.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <system_error>

#include "robot/robot.hpp"
#include "terminal/console.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNames = 5;

// Whether the session of this file has ended: its process no longer locks it. No, if that is not known.
bool IsStale(const fs::path& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return false;
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  const bool known = fcntl(fd, F_OFD_GETLK, &lock) == 0;
  close(fd);
  return known && lock.l_type == F_UNLCK;
}

}  // namespace

std::string DomainOf(const Session& session) {
  const char* chosen = std::getenv("HGROS_DOMAIN");
  return chosen == nullptr || *chosen == '\0' ? session.config().discovery.domain : chosen;
}

// Folders of the registry as docs/deployment.md names them: FOLDER/DOMAIN/SESSION.
std::vector<DomainOnHost> DomainsOnHost() {
  std::set<fs::path> folders;
  if (const char* runtime = std::getenv("XDG_RUNTIME_DIR")) folders.insert(fs::path(runtime) / "hgros");
  std::error_code error;
  for (const auto& user : fs::directory_iterator("/run/user", error)) folders.insert(user.path() / "hgros");
  for (const auto& entry : fs::directory_iterator("/tmp", error)) {
    if (entry.path().filename().string().starts_with("hgros-")) folders.insert(entry.path());
  }
  std::vector<DomainOnHost> domains;
  for (const fs::path& folder : folders) {
    struct stat status {};
    const bool foreign = stat(folder.c_str(), &status) == 0 && status.st_uid != geteuid();
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      DomainOnHost domain;
      domain.name = entry.path().filename().string();
      domain.folder = entry.path();
      if (domain.name.starts_with('.') || !entry.is_directory(error) || entry.is_symlink(error)) continue;
      if (foreign) domain.other_user = status.st_uid;
      for (const auto& file : fs::directory_iterator(entry.path(), error)) {
        if (file.path().filename().string().find_first_not_of("0123456789abcdef") != std::string::npos) continue;
        ++(IsStale(file.path()) ? domain.stale : domain.sessions);
      }
      domains.push_back(std::move(domain));
    }
  }
  return domains;
}

std::string NoSessions(const std::string& own) {
  std::set<std::string> others;
  for (const DomainOnHost& domain : DomainsOnHost()) {
    if (domain.sessions > 0 && !domain.other_user && domain.name != own) others.insert(Visible(domain.name));
  }
  std::string text = "No sessions in domain " + Visible(own) + ".";
  if (others.empty()) return text;
  std::size_t named = 0;
  for (const std::string& name : others) {
    if (named == kMostNames) return text + " and " + std::to_string(others.size() - named) + " more.";
    text += (named++ == 0 ? " There are some in: " : ", ") + name;
  }
  return text + ".";
}

void SayNone(Robot& robot, std::string_view what) {
  const std::string own = DomainOf(robot.session());
  const bool somebody = !robot.Channels(true).empty();
  robot.surroundings().console.Say(somebody ? "No " + std::string(what) + " in domain " + Visible(own) + "."
                                            : NoSessions(own));
}

}  // namespace hgros::cli

#include "launch/robot_socket.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/discovery/domain.hpp"
#include "launch/robot_report.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

constexpr const char* kListens = "00010000";  // Among the flags of /proc/net/unix.

// The beginning of the names of all sockets of this user and domain.
std::string SocketPrefix() { return "hgros-run/" + std::to_string(getuid()) + "/" + DomainName() + "/"; }

struct Address {
  sockaddr_un address{};
  socklen_t size = 0;
};

Address AddressOf(const std::string& robot) {
  const std::string name = SocketPrefix() + robot;
  Address made;
  made.address.sun_family = AF_UNIX;
  if (name.size() + 1 > sizeof made.address.sun_path) {
    throw Error("The name of the robot and its domain are too long together.", {},
                "Shorten one of them by " + std::to_string(name.size() + 1 - sizeof made.address.sun_path) + " bytes.");
  }
  std::memcpy(made.address.sun_path + 1, name.data(), name.size());  // The first byte is 0: it has no file.
  made.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return made;
}

bool IsOurs(int socket) {
  ucred peer{};
  socklen_t size = sizeof peer;
  return getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 && (peer.uid == getuid() || peer.uid == 0);
}

// The socket that listens at this name, as a process's descriptors show it; empty: none does.
std::string ListenerAt(const std::string& robot) {
  const std::string name = " @" + SocketPrefix() + robot;
  std::ifstream file("/proc/net/unix");
  for (std::string line; std::getline(file, line);) {
    if (!line.ends_with(name)) continue;
    std::istringstream fields(line);
    std::string skipped;
    std::string flags;
    std::string inode;
    fields >> skipped >> skipped >> skipped >> flags >> skipped >> skipped >> inode;
    if (flags == kListens) return "socket:[" + inode + "]";
  }
  return {};
}

// Whether a process of this user has the socket. One that does not accept connections cannot be asked.
bool HasOwnProcess(const std::string& listener) {
  using Entries = std::filesystem::directory_iterator;
  std::error_code error;
  for (Entries process("/proc", error); !error && process != Entries(); process.increment(error)) {
    struct stat owner {};
    if (stat(process->path().c_str(), &owner) != 0 || owner.st_uid != getuid()) continue;
    std::error_code gone;  // Processes and descriptors may end meanwhile.
    for (Entries at(process->path() / "fd", gone); !gone && at != Entries(); at.increment(gone)) {
      if (std::filesystem::read_symlink(at->path(), gone) == listener) return true;
      gone.clear();
    }
  }
  return false;
}

// Whether it is a robot of this user. Any user can take any name.
bool IsOurRobot(const std::string& name) {
  const Address address = AddressOf(name);
  const MessageStream stream(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (connect(stream.descriptor(), reinterpret_cast<const sockaddr*>(&address.address), address.size) == 0) {
    return IsOurs(stream.descriptor());
  }
  return errno == EAGAIN && HasOwnProcess(ListenerAt(name));  // It has no time now.
}

bool CanBeARobot(const std::string& name) {
  return ChannelNameFault(name).empty() && name.find('/') == std::string::npos;
}

}  // namespace

std::string DomainName() {
  const char* set = std::getenv("HGROS_DOMAIN");
  std::string domain(set != nullptr && *set != '\0' ? set : kDefaultDomain);
  if (IsDomain(domain)) return domain;
  throw Error("\"" + Visible(domain) + "\" cannot name a domain; HGROS_DOMAIN sets it.", {},
              "Use 1 to 64 letters, digits, '_', '-' and '.', not beginning with a '.'.");
}

RobotSocket::RobotSocket(const std::string& name) {
  if (std::string fault = ChannelNameFault(name); !fault.empty() || name.find('/') != std::string::npos) {
    throw Error("\"" + name + "\" cannot be the name of a robot: " + (fault.empty() ? "it has a slash" : fault) + ".",
                {}, "Give another one with --name.");
  }
  const Address address = AddressOf(name);
  descriptor_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor_ >= 0 && bind(descriptor_, reinterpret_cast<const sockaddr*>(&address.address), address.size) == 0 &&
      listen(descriptor_, 16) == 0) {
    return;
  }
  const int error = errno;
  if (descriptor_ >= 0) close(descriptor_);
  if (error == EADDRINUSE && !IsOurRobot(name)) {
    throw Error("Another user of this host has taken the name of the robot \"" + name + "\".", {},
                "Give this one another name with --name, or set HGROS_DOMAIN.");
  }
  if (error == EADDRINUSE) {
    throw Error("A robot \"" + name + "\" is running already.", {},
                "End it with `hgros stop " + name + "`, or give this one another name with --name.");
  }
  throw Error("The system refused the socket of the robot: " + std::generic_category().message(error) + ".");
}

RobotSocket::~RobotSocket() {
  close(descriptor_);
  if (spare_ >= 0) close(spare_);
}

std::unique_ptr<MessageStream> RobotSocket::Accept() {
  const auto accept = [this] { return accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK); };
  int client = accept();
  if (client < 0 && (errno == EMFILE || errno == ENFILE) && spare_ >= 0) {
    close(std::exchange(spare_, -1));
    client = accept();
  }
  if (client < 0) return nullptr;
  auto stream = std::make_unique<MessageStream>(client);
  return IsOurs(client) ? std::move(stream) : nullptr;
}

bool RobotSocket::HasSpare() {
  if (spare_ < 0) spare_ = open("/dev/null", O_RDONLY | O_CLOEXEC);
  return spare_ >= 0;
}

std::vector<std::string> RunningRobots() {
  std::vector<std::string> robots;
  const std::string prefix = "@" + SocketPrefix();
  std::ifstream file("/proc/net/unix");
  for (std::string line; std::getline(file, line);) {
    const std::size_t begin = line.find(prefix);
    if (begin == std::string::npos) continue;
    robots.push_back(line.substr(begin + prefix.size()));  // Connections have the name, too.
  }
  std::ranges::sort(robots);
  robots.erase(std::unique(robots.begin(), robots.end()), robots.end());
  std::erase_if(robots, [](const std::string& robot) { return !CanBeARobot(robot) || !IsOurRobot(robot); });
  return robots;
}

std::string RobotNamed(const std::string& wanted, bool may_have_ended) {
  const std::vector<std::string> robots = RunningRobots();
  const std::string where = " in the domain " + DomainName();
  if (!wanted.empty() && std::ranges::find(robots, wanted) != robots.end()) return wanted;
  if (!wanted.empty() || robots.empty()) {
    const std::vector<std::string> ended = RobotsWithReport();
    const auto found = wanted.empty() ? ended.begin() : std::ranges::find(ended, wanted);
    if (found != ended.end() && may_have_ended) return *found;
    if (found != ended.end()) {
      throw Error("The robot \"" + *found + "\" has ended.", {},
                  "`hgros logs --robot " + *found + "` shows why. Start it with `hgros run`.");
    }
  }
  if (!wanted.empty()) {
    const std::string nearest = NearestName(wanted, robots);
    throw Error("No robot \"" + wanted + "\" was started here by this user" + where + ".", {},
                nearest.empty() ? "`hgros ps` lists those that run." : "Did you mean \"" + nearest + "\"?");
  }
  if (robots.size() == 1) return robots.front();
  if (robots.empty())
    throw Error("No robot was started here by this user" + where + ".", {}, "Start one with `hgros run`.");
  std::string names;
  for (const std::string& robot : robots) names += (names.empty() ? "" : ", ") + robot;
  throw Error("Several robots run: " + names + ".", {}, "Name one with --robot, or after `hgros stop`.");
}

std::unique_ptr<MessageStream> ConnectToRobot(const std::string& name) {
  const Error unreached("No robot \"" + name + "\" can be reached.", {}, "`hgros ps` lists those that run.");
  const Address address = AddressOf(name);
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor < 0) throw Error("The system refused a socket: " + std::generic_category().message(errno) + ".");
  auto stream = std::make_unique<MessageStream>(descriptor);
  const auto connects = [&] {
    return connect(descriptor, reinterpret_cast<const sockaddr*>(&address.address), address.size) == 0;
  };
  if (!connects()) {
    if (errno != EAGAIN || !HasOwnProcess(ListenerAt(name))) throw unreached;
    // It has no time now.
    (void)fcntl(descriptor, F_SETFL, 0);
    const timeval patience{5, 0};
    (void)setsockopt(descriptor, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    if (!connects()) throw unreached;
    (void)fcntl(descriptor, F_SETFL, O_NONBLOCK);
  }
  if (!IsOurs(descriptor)) throw unreached;
  return stream;
}

}  // namespace hgros::cli

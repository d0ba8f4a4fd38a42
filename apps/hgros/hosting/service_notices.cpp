#include "hosting/service_notices.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

// The value of a variable, which is then removed.
std::string Taken(const char* name) {
  const char* value = std::getenv(name);
  std::string text = value == nullptr ? "" : value;
  (void)unsetenv(name);
  return text;
}

}  // namespace

ServiceNotices::ServiceNotices() : address_(Taken("NOTIFY_SOCKET")) {
  const std::string time = Taken("WATCHDOG_USEC");
  const std::string watched = Taken("WATCHDOG_PID");
  const bool known = address_.starts_with('/') || address_.starts_with('@');  // vsock is for virtual machines.
  if (!known || address_.size() < 2 || address_.size() >= sizeof(sockaddr_un::sun_path)) return;
  if (address_.front() == '@') address_.front() = '\0';
  descriptor_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (watched.empty() || watched == std::to_string(getpid())) {
    watchdog_ = std::chrono::microseconds(std::strtoll(time.c_str(), nullptr, 10));
  }
}

ServiceNotices::~ServiceNotices() {
  if (descriptor_ >= 0) close(descriptor_);
}

void ServiceNotices::Tell(std::string_view notice) const noexcept {
  if (descriptor_ < 0) return;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address_.data(), address_.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  (void)sendto(descriptor_, notice.data(), notice.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
               reinterpret_cast<const sockaddr*>(&to), size);
}

void ServiceNotices::TellStatus(std::string_view status) const { Tell("STATUS=" + Visible(status)); }

}  // namespace hgros::cli

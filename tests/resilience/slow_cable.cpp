#include "resilience/slow_cable.hpp"

#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "support/cable.hpp"

namespace hgros::resilience {
namespace {

using test::Ip;

// The end of the cable in that host; negative if there is none.
int Plug(const std::string& host, const std::string& address) {
  if (!Ip("netns add " + host)) return -1;
  int fd = -1;
  test::On(host, [&fd] {
    fd = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
    ifreq request{};
    std::strncpy(request.ifr_name, "eth0", IFNAMSIZ - 1);
    request.ifr_flags = IFF_TAP | IFF_NO_PI;
    if (fd >= 0 && ioctl(fd, TUNSETIFF, &request) != 0) {
      close(fd);
      fd = -1;
    }
  });
  const bool up = fd >= 0 && Ip("-n " + host + " addr add " + address + " broadcast + dev eth0") &&
                  Ip("-n " + host + " link set eth0 up");
  if (fd >= 0 && !up) close(fd);
  return up ? fd : -1;
}

}  // namespace

SlowCable::SlowCable(std::chrono::milliseconds each_way, double bits_per_second)
    : each_way_(each_way), bits_per_second_(bits_per_second) {
  test::RemoveLeftNamespaces();
  lanes_[0].from = lanes_[1].to = Plug(left, "10.196.0.1/24");
  lanes_[0].to = lanes_[1].from = Plug(right, "10.196.0.2/24");
  ready = lanes_[0].from >= 0 && lanes_[0].to >= 0 && pipe2(stop_, O_CLOEXEC) == 0;
  if (ready) thread_ = std::thread([this] { Run(); });
}

SlowCable::~SlowCable() {
  if (thread_.joinable()) {
    close(stop_[1]);
    thread_.join();
    close(stop_[0]);
  }
  for (const Lane& lane : lanes_) {
    if (lane.from >= 0) close(lane.from);
  }
  for (const std::string& host : {left, right}) (void)Ip("netns del " + host);
}

void SlowCable::Read(Lane& lane, Time now) const {
  std::array<char, 2048> frame;
  for (ssize_t size = 0; (size = read(lane.from, frame.data(), frame.size())) > 0;) {
    if (cut_) continue;
    lane.free = std::max(lane.free, now);
    if (bits_per_second_ > 0) {
      lane.free +=
          std::chrono::nanoseconds(static_cast<std::int64_t>(8e9 * static_cast<double>(size) / bits_per_second_));
    }
    lane.frames.push_back({lane.free + each_way_, {frame.data(), static_cast<std::size_t>(size)}});
  }
}

void SlowCable::Write(Lane& lane, Time now) {
  for (; !lane.frames.empty() && lane.frames.front().due <= now; lane.frames.pop_front()) {
    const std::string& bytes = lane.frames.front().bytes;
    [[maybe_unused]] const auto written = write(lane.to, bytes.data(), bytes.size());
  }
}

void SlowCable::Run() {
  for (;;) {
    Time wake = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    for (Lane& lane : lanes_) {
      Write(lane, std::chrono::steady_clock::now());
      if (!lane.frames.empty()) wake = std::min(wake, lane.frames.front().due);
    }
    const auto patience = std::chrono::ceil<std::chrono::milliseconds>(wake - std::chrono::steady_clock::now()).count();
    pollfd fds[] = {{stop_[0], POLLIN, 0}, {lanes_[0].from, POLLIN, 0}, {lanes_[1].from, POLLIN, 0}};
    poll(fds, 3, static_cast<int>(std::max<std::int64_t>(patience, 0)));
    if (fds[0].revents != 0) return;
    for (Lane& lane : lanes_) Read(lane, std::chrono::steady_clock::now());
  }
}

}  // namespace hgros::resilience

#include "hosting/end_notice.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::cli {

namespace {

int MakeEvent() {
  const int event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (event < 0) throw Error("This process can open no more files.", {}, "Raise the limit (ulimit -n).");
  return event;
}

}  // namespace

EndNotice::EndNotice(int ended, std::function<void()> tell)
    : done_(MakeEvent()), thread_([this, ended, tell = std::move(tell)] {
        std::array<pollfd, 2> watched{pollfd{ended, POLLIN, 0}, pollfd{done_, POLLIN, 0}};
        while (poll(watched.data(), watched.size(), -1) < 0 && errno == EINTR) {
        }
        if (watched[0].revents != 0) tell();
      }) {}

EndNotice::~EndNotice() {
  const std::uint64_t one = 1;
  (void)!write(done_, &one, sizeof one);
  thread_.join();
  close(done_);
}

}  // namespace hgros::cli

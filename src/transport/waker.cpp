#include "transport/waker.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "hgros/base/error.hpp"

namespace hgros {

Waker::Waker() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (fd_ < 0) {
    throw Error(std::string("Cannot create an eventfd: ") + std::strerror(errno) + ".", {},
                "Raise the limit of open files (ulimit -n).");
  }
}

Waker::~Waker() { close(fd_); }

void Waker::Wake() noexcept {
  const std::uint64_t one = 1;
  // Fails only when the counter is full, and then the descriptor is readable anyway.
  [[maybe_unused]] const auto written = write(fd_, &one, sizeof one);
}

void Waker::Clear() noexcept {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto taken = read(fd_, &count, sizeof count);
}

}  // namespace hgros

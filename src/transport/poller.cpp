#include "transport/poller.hpp"

#include <sys/epoll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>

#include "hgros/base/error.hpp"

namespace hgros {

Poller::Poller() : fd_(epoll_create1(EPOLL_CLOEXEC)) {
  if (fd_ < 0) {
    throw Error(std::string("Cannot create an epoll descriptor: ") + std::strerror(errno) + ".", {},
                "Raise the limit of open files (ulimit -n).");
  }
}

Poller::~Poller() { close(fd_); }

void Poller::Add(int fd, std::atomic<bool>& flag) {
  epoll_event event{};
  event.events = EPOLLIN | EPOLLET;
  event.data.ptr = &flag;
  if (epoll_ctl(fd_, EPOLL_CTL_ADD, fd, &event) != 0) {
    throw Error(std::string("Cannot wait for a descriptor: ") + std::strerror(errno) + ".");
  }
}

bool Poller::AddOnce(int fd, std::atomic<bool>& flag) noexcept {
  epoll_event event{};
  event.events = EPOLLIN | EPOLLONESHOT;
  event.data.ptr = &flag;
  return epoll_ctl(fd_, EPOLL_CTL_ADD, fd, &event) == 0 ||
         (errno == EEXIST && epoll_ctl(fd_, EPOLL_CTL_MOD, fd, &event) == 0);
}

void Poller::Wait(int timeout_ms) noexcept {
  std::array<epoll_event, 16> events;
  const int count = epoll_wait(fd_, events.data(), static_cast<int>(events.size()), timeout_ms);
  for (int i = 0; i < count; ++i) {
    static_cast<std::atomic<bool>*>(events[static_cast<std::size_t>(i)].data.ptr)->store(true);
  }
}

}  // namespace hgros

#include "transport/zmq/publish/unfinished_messages.hpp"

#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "hgros/base/error.hpp"
#include "transport/zmq/connection.hpp"

namespace hgros::zmq {
UnfinishedMessages::UnfinishedMessages()
    : epoll_(epoll_create1(EPOLL_CLOEXEC)), timer_(timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = timer_;
  if (epoll_ >= 0 && timer_ >= 0 && epoll_ctl(epoll_, EPOLL_CTL_ADD, timer_, &event) == 0) return;
  const int error = errno;
  Close();
  throw Error(std::string("Cannot watch the connections of an endpoint: ") + std::strerror(error) + ".", {},
              "Raise the limit of open files (ulimit -n).");
}

void UnfinishedMessages::Close() noexcept {
  Clear();
  if (epoll_ >= 0) close(std::exchange(epoll_, -1));
  if (timer_ >= 0) close(std::exchange(timer_, -1));
}

void UnfinishedMessages::Add(int connection, SteadyTime now) {
  Remove(connection);
  connections_[connection] = {.settled_at = now};
  WaitForBytes(connection);
}

// Once: then the timer takes over. A closed descriptor leaves the epoll set by itself.
void UnfinishedMessages::WaitForBytes(int connection) {
  epoll_event event{};
  event.events = EPOLLIN | EPOLLONESHOT;
  event.data.fd = connection;
  if (epoll_ctl(epoll_, EPOLL_CTL_ADD, connection, &event) != 0 && errno == EEXIST) {
    (void)epoll_ctl(epoll_, EPOLL_CTL_MOD, connection, &event);
  }
}

void UnfinishedMessages::NoteMessage(int connection) {
  const auto found = connections_.find(connection);
  if (found == connections_.end() || std::exchange(found->second.delivered, true)) return;
  if (found->second.moving) delivered_.push_back(connection);
}

void UnfinishedMessages::Remove(int connection) {
  const auto found = connections_.find(connection);
  if (found == connections_.end()) return;
  moving_ -= found->second.moving ? 1 : 0;
  connections_.erase(found);
}

void UnfinishedMessages::Clear() {
  connections_.clear();
  delivered_.clear();
  moving_ = 0;
}

void UnfinishedMessages::SettleDelivered(SteadyTime now) {
  if (delivered_.empty()) return;
  for (const int fd : delivered_) {
    const auto found = connections_.find(fd);
    if (found == connections_.end() || !found->second.moving || !found->second.delivered) continue;
    // More often, looks take less time.
    if (now - found->second.settled_at >= kSettleEvery) Settle(fd, found->second, now);
  }
  delivered_.clear();
  if (moving_ == 0) StopTimer();
}

void UnfinishedMessages::Settle(int fd, Connection& connection, SteadyTime now) {
  const auto read = BytesRead(fd);
  if (read && (connection.delivered || *read < connection.settled)) {
    connection.settled = *read;
    connection.settled_at = now;
  }
  connection.seen = read.value_or(0);
  moving_ -= connection.moving ? 1 : 0;
  connection.moving = connection.delivered = false;
  if (read) WaitForBytes(fd);
}

void UnfinishedMessages::SetTimer() {
  if (timer_runs_) return;
  itimerspec time{};
  time.it_value.tv_nsec = std::chrono::nanoseconds(kLookEvery).count();
  timer_runs_ = timerfd_settime(timer_, 0, &time, nullptr) == 0;
}

void UnfinishedMessages::StopTimer() {
  const itimerspec never{};
  if (timer_runs_ && timerfd_settime(timer_, 0, &never, nullptr) == 0) timer_runs_ = false;
}

bool UnfinishedMessages::IsLookDue() {
  if (!input_.exchange(false)) return due_;
  std::array<epoll_event, 64> events;
  for (int count = 64; count == static_cast<int>(events.size());) {
    count = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 0);
    for (int i = 0; i < count; ++i) {
      const int fd = events[static_cast<std::size_t>(i)].data.fd;
      if (fd == timer_) {
        std::uint64_t times = 0;
        due_ = read(timer_, &times, sizeof times) > 0 || due_;
        timer_runs_ = false;
      } else if (const auto found = connections_.find(fd); found != connections_.end()) {
        moving_ += std::exchange(found->second.moving, true) ? 0 : 1;
        if (found->second.delivered) delivered_.push_back(fd);
        SetTimer();
      }
    }
  }
  return due_;
}

std::vector<int> UnfinishedMessages::Look(SteadyTime now) {
  due_ = false;
  std::vector<int> too_long;
  for (auto& [fd, connection] : connections_) {
    if (!connection.moving) continue;
    const auto read = BytesRead(fd);
    if (!read || *read == connection.seen || connection.delivered || *read < connection.settled) {
      Settle(fd, connection, now);
      continue;
    }
    // Whole messages among the bytes of the last look would have been delivered by now.
    const auto quiet = std::chrono::duration_cast<std::chrono::seconds>(now - connection.settled_at).count();
    const std::uint64_t most = kMostBytes + kPingBytesPerSecond * static_cast<std::uint64_t>(quiet);
    if (connection.seen > connection.settled + most) {
      too_long.push_back(fd);
      connection.settled = *read;
      connection.settled_at = now;
    }
    connection.seen = *read;
  }
  if (moving_ > 0) SetTimer();
  return too_long;
}

}  // namespace hgros::zmq

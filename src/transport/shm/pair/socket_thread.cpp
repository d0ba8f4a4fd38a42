#include "transport/shm/pair/socket_thread.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/system_limits.hpp"

namespace hgros::shm {
namespace {

// A descriptor's data for epoll: its source in the upper bits, and the pair's number in the lower ones.
constexpr int kSourceShift = 32;
constexpr std::uint64_t kWakerMark = 0;
constexpr std::int64_t kLongestWaitMs = 60'000;

bool AddToEpoll(const Handle& epoll, int fd, std::uint32_t events, std::uint64_t mark) noexcept {
  epoll_event event{};
  event.events = events;
  event.data.u64 = mark;
  return epoll_ctl(epoll.fd(), EPOLL_CTL_ADD, fd, &event) == 0;
}

}  // namespace

SocketThread::SocketThread() : epoll_(epoll_create1(EPOLL_CLOEXEC)) {
  if (!epoll_.valid()) {
    throw Error(std::string("Cannot create an epoll descriptor: ") + std::strerror(errno) + ".", {},
                "Raise the limit of open files (ulimit -n).");
  }
  if (!AddToEpoll(epoll_, waker_.fd(), EPOLLIN, kWakerMark)) {
    throw Error(std::string("Cannot wait for a descriptor: ") + std::strerror(errno) + ".");
  }
}

void SocketThread::Start(Handler& handler) {
  handler_ = &handler;
  thread_ = StartThread<std::jthread>("the thread of shared memory's sockets",
                                      [this](const std::stop_token& stop) { Run(stop); });
}

void SocketThread::Stop() noexcept {
  thread_.request_stop();
  waker_.Wake();
  if (thread_.joinable()) thread_.join();
}

bool SocketThread::Watch(const Handle& handle, std::uint32_t events, Source source, std::uint32_t number) noexcept {
  return AddToEpoll(epoll_, handle.fd(), events, static_cast<std::uint64_t>(source) << kSourceShift | number);
}

bool SocketThread::Unwatch(const Handle& handle) noexcept {
  return epoll_ctl(epoll_.fd(), EPOLL_CTL_DEL, handle.fd(), nullptr) == 0;
}

void SocketThread::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const SteadyTime next = handler_->DoWhatIsDue(std::chrono::steady_clock::now());
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next - std::chrono::steady_clock::now());
    std::array<epoll_event, 16> events;
    const int count = epoll_wait(epoll_.fd(), events.data(), static_cast<int>(events.size()),
                                 static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, kLongestWaitMs)));
    for (int i = 0; i < count; ++i) {
      const std::uint64_t mark = events[static_cast<std::size_t>(i)].data.u64;
      if (mark == kWakerMark) {
        waker_.Clear();
      } else {
        handler_->OnReady(static_cast<Source>(mark >> kSourceShift), static_cast<std::uint32_t>(mark));
      }
    }
    Actions posted;
    {
      const std::scoped_lock lock(posted_mutex_);
      posted.swap(posted_);
    }
    for (const auto& action : posted) action();
  }
}

void SocketThread::Post(std::function<void()> action) {
  {
    const std::scoped_lock lock(posted_mutex_);
    posted_.push_back(std::move(action));
  }
  waker_.Wake();
}

void SocketThread::PostAll(Actions&& actions) {
  {
    const std::scoped_lock lock(posted_mutex_);
    for (auto& action : actions) posted_.push_back(std::move(action));
  }
  actions.clear();
  waker_.Wake();
}

void SocketThread::PostFor(Pair& pair, std::function<void(const std::shared_ptr<Pair>&)> action) {
  Post([pair = pair.weak_from_this(), action = std::move(action)] {
    if (const auto still = pair.lock()) action(still);
  });
}

void SocketThread::FlushSoon(Pair& pair) {
  PostFor(pair, [this](const auto& same) {
    if (same->socket.Flush()) FlushSoon(*same);
  });
}

void SocketThread::Distrust(Pair& liar, const std::string& what) {
  if (liar.ending.load()) return;
  PostFor(liar, [this, what](const auto& pair) { handler_->OnLie(pair, what); });
}

void SocketThread::FinishPair(const std::shared_ptr<Pair>& pair) {
  Post([this, pair] { handler_->OnAllRead(pair); });
}

}  // namespace hgros::shm

#include "conformance/tcp_forwarder.hpp"

#include <fcntl.h>
#include <poll.h>

#include <stdexcept>

namespace hgros::conformance {
namespace {

// False when the connection has ended.
bool Pump(int from, int to) {
  char buffer[65536];
  const ssize_t size = recv(from, buffer, sizeof buffer, 0);
  if (size <= 0) return false;
  for (ssize_t done = 0; done < size;) {
    const ssize_t sent = send(to, buffer + done, static_cast<std::size_t>(size - done), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    done += sent;
  }
  return true;
}

}  // namespace

TcpForwarder::TcpForwarder(std::uint16_t target_port) : relay_(target_port) {
  if (pipe2(wake_, O_CLOEXEC) != 0) throw std::runtime_error("no forwarder");
  thread_ = std::thread([this] { Run(); });
}

TcpForwarder::~TcpForwarder() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  [[maybe_unused]] const auto written = write(wake_[1], "", 1);
  thread_.join();
  for (const auto& pair : pairs_) pair.Close();
  close(wake_[0]);
  close(wake_[1]);
}

void TcpForwarder::Set(State state) {
  std::unique_lock lock(mutex_);
  wanted_ = state;
  [[maybe_unused]] const auto written = write(wake_[1], "", 1);
  changed_.wait(lock, [&] { return reached_ == state; });
}

void TcpForwarder::Stall() { Set(State::kStalled); }
void TcpForwarder::Resume() { Set(State::kOpen); }
void TcpForwarder::Cut() { Set(State::kCut); }

void TcpForwarder::Run() {
  for (;;) {
    State state;
    {
      const std::scoped_lock lock(mutex_);
      if (stop_) return;
      state = wanted_;
    }
    if (state == State::kCut) {
      for (const auto& pair : pairs_) pair.Close();
      pairs_.clear();
    }
    {
      const std::scoped_lock lock(mutex_);
      reached_ = state;
    }
    changed_.notify_all();

    std::vector<pollfd> fds{{wake_[0], POLLIN, 0},
                            {relay_.listener(), static_cast<short>(state == State::kStalled ? 0 : POLLIN), 0}};
    if (state == State::kOpen) {
      for (const auto& pair : pairs_) {
        fds.push_back({pair.client, POLLIN, 0});
        fds.push_back({pair.server, POLLIN, 0});
      }
    }
    poll(fds.data(), fds.size(), -1);
    if (fds[0].revents != 0) {
      char byte;
      [[maybe_unused]] const auto got = read(wake_[0], &byte, 1);
      continue;
    }
    if (fds[1].revents != 0) {
      if (state == State::kCut) {
        relay_.Refuse();
      } else if (const auto pair = relay_.Accept()) {
        pairs_.push_back(*pair);
      }
      continue;
    }
    std::vector<test::RelayPort::Pair> kept;
    for (std::size_t i = 0; i < pairs_.size() && 2 * i + 3 < fds.size(); ++i) {
      const test::RelayPort::Pair pair = pairs_[i];
      const bool alive = (fds[2 + 2 * i].revents == 0 || Pump(pair.client, pair.server)) &&
                         (fds[3 + 2 * i].revents == 0 || Pump(pair.server, pair.client));
      if (alive) {
        kept.push_back(pair);
      } else {
        pair.Close();
      }
    }
    pairs_ = std::move(kept);
  }
}

}  // namespace hgros::conformance

#include "conformance/tcp_forwarder.hpp"

#include <fcntl.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <vector>

namespace hgros::conformance {

TcpForwarder::TcpForwarder(std::uint16_t target_port, std::chrono::milliseconds each_way, const char* target_ip)
    : relay_(target_port, target_ip), each_way_(each_way) {
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
  for (const Connection& connection : connections_) Close(connection);
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

void TcpForwarder::Close(const Connection& connection) {
  close(connection.lanes[0].from);
  close(connection.lanes[0].to);
}

void TcpForwarder::Accept() {
  const auto pair = relay_.Accept();
  if (!pair) return;
  fcntl(pair->client, F_SETFL, O_NONBLOCK);
  fcntl(pair->server, F_SETFL, O_NONBLOCK);
  Connection& connection = connections_.emplace_back();
  connection.lanes[0] = {pair->client, pair->server, {}};
  connection.lanes[1] = {pair->server, pair->client, {}};
}

void TcpForwarder::Read(Connection& connection, Lane& lane) const {
  std::string bytes(65536, '\0');
  const ssize_t size = recv(lane.from, bytes.data(), bytes.size(), 0);
  if (size <= 0) {
    connection.ended = connection.ended || size == 0 || (errno != EAGAIN && errno != EINTR);
    return;
  }
  bytes.resize(static_cast<std::size_t>(size));
  lane.pieces.push_back({std::chrono::steady_clock::now() + each_way_, std::move(bytes)});
}

void TcpForwarder::Write(Connection& connection, Lane& lane) {
  while (!lane.pieces.empty() && lane.pieces.front().due <= std::chrono::steady_clock::now()) {
    std::string& bytes = lane.pieces.front().bytes;
    const ssize_t sent = send(lane.to, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0) {
      connection.ended = connection.ended || (errno != EAGAIN && errno != EINTR);
      return;
    }
    bytes.erase(0, static_cast<std::size_t>(sent));
    if (bytes.empty()) lane.pieces.pop_front();
  }
}

void TcpForwarder::Run() {
  for (;;) {
    State state;
    {
      const std::scoped_lock lock(mutex_);
      if (stop_) return;
      state = wanted_;
    }
    if (state == State::kCut) {
      for (const Connection& connection : connections_) Close(connection);
      connections_.clear();
    }
    {
      const std::scoped_lock lock(mutex_);
      reached_ = state;
    }
    changed_.notify_all();

    std::vector<pollfd> fds{{wake_[0], POLLIN, 0},
                            {relay_.listener(), static_cast<short>(state == State::kStalled ? 0 : POLLIN), 0}};
    const Time now = std::chrono::steady_clock::now();
    Time wake = now + std::chrono::hours(1);
    for (const Connection& connection : connections_) {
      if (state != State::kOpen) break;
      for (const Lane& lane : connection.lanes) {
        const bool waits = !lane.pieces.empty();
        const bool due = waits && lane.pieces.front().due <= now;
        if (waits && !due) wake = std::min(wake, lane.pieces.front().due);
        // Without a delay, a receiver that does not read holds up the sender.
        fds.push_back({waits && each_way_.count() == 0 ? -1 : lane.from, POLLIN, 0});
        fds.push_back({due ? lane.to : -1, POLLOUT, 0});
      }
    }
    poll(fds.data(), fds.size(), static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(wake - now).count()));
    if (fds[0].revents != 0) {
      char byte;
      [[maybe_unused]] const auto got = read(wake_[0], &byte, 1);
      continue;
    }
    if (fds[1].revents != 0) {
      if (state == State::kCut) {
        relay_.Refuse();
      } else {
        Accept();
      }
      continue;
    }
    if (state != State::kOpen) continue;
    std::size_t next = 2;
    for (Connection& connection : connections_) {
      for (Lane& lane : connection.lanes) {
        if (fds[next].revents != 0) Read(connection, lane);
        Write(connection, lane);
        next += 2;
      }
    }
    std::erase_if(connections_, [](const Connection& connection) {
      if (connection.ended) Close(connection);
      return connection.ended;
    });
  }
}

}  // namespace hgros::conformance

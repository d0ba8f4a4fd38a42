#include "resilience/delay_line.hpp"

#include <fcntl.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <vector>

namespace hgros::resilience {

DelayLine::DelayLine(std::uint16_t target_port, std::chrono::milliseconds each_way, const char* target_ip)
    : relay_(target_port, target_ip), each_way_(each_way) {
  if (pipe2(stop_, O_CLOEXEC) != 0) throw std::runtime_error("no delay line");
  thread_ = std::thread([this] { Run(); });
}

DelayLine::~DelayLine() {
  close(stop_[1]);
  thread_.join();
  for (const Connection& connection : connections_) Close(connection);
  close(stop_[0]);
}

void DelayLine::Close(const Connection& connection) {
  close(connection.lanes[0].from);
  close(connection.lanes[0].to);
}

void DelayLine::Accept() {
  const auto pair = relay_.Accept();
  if (!pair) return;
  fcntl(pair->client, F_SETFL, O_NONBLOCK);
  fcntl(pair->server, F_SETFL, O_NONBLOCK);
  Connection& connection = connections_.emplace_back();
  connection.lanes[0] = {pair->client, pair->server, {}};
  connection.lanes[1] = {pair->server, pair->client, {}};
}

void DelayLine::Read(Connection& connection, Lane& lane) {
  std::string bytes(65536, '\0');
  const ssize_t size = recv(lane.from, bytes.data(), bytes.size(), 0);
  if (size <= 0) {
    connection.ended = size == 0 || (errno != EAGAIN && errno != EINTR);
    return;
  }
  bytes.resize(static_cast<std::size_t>(size));
  lane.pieces.push_back({std::chrono::steady_clock::now() + each_way_, std::move(bytes)});
}

void DelayLine::Write(Connection& connection, Lane& lane, Time now) {
  while (!lane.pieces.empty() && lane.pieces.front().due <= now) {
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

void DelayLine::Run() {
  for (;;) {
    std::vector<pollfd> fds{{stop_[0], POLLIN, 0}, {relay_.listener(), POLLIN, 0}};
    const Time now = std::chrono::steady_clock::now();
    Time wake = now + std::chrono::hours(1);
    for (Connection& connection : connections_) {
      for (const Lane& lane : connection.lanes) {
        const bool due = !lane.pieces.empty() && lane.pieces.front().due <= now;
        if (!lane.pieces.empty() && !due) wake = std::min(wake, lane.pieces.front().due);
        fds.push_back({lane.from, POLLIN, 0});
        fds.push_back({lane.to, static_cast<short>(due ? POLLOUT : 0), 0});
      }
    }
    const auto patience = std::chrono::ceil<std::chrono::milliseconds>(wake - now).count();
    poll(fds.data(), fds.size(), static_cast<int>(patience));
    if (fds[0].revents != 0) return;
    const Time after = std::chrono::steady_clock::now();
    std::size_t i = 2;
    for (Connection& connection : connections_) {
      for (Lane& lane : connection.lanes) {
        if (fds[i].revents != 0) Read(connection, lane);
        Write(connection, lane, after);
        i += 2;
      }
    }
    std::erase_if(connections_, [](const Connection& connection) {
      if (connection.ended) Close(connection);
      return connection.ended;
    });
    if (fds[1].revents != 0) Accept();
  }
}

}  // namespace hgros::resilience

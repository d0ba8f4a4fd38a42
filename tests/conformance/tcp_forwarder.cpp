#include "conformance/tcp_forwarder.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>

namespace hgros::conformance {
namespace {

sockaddr_in Local(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

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

TcpForwarder::TcpForwarder(std::uint16_t target_port) : target_port_(target_port) {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  auto address = Local(0);
  socklen_t size = sizeof address;
  if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(listener_, 16) != 0 ||
      getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0 || pipe2(wake_, O_CLOEXEC) != 0) {
    throw std::runtime_error("no forwarder");
  }
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { Run(); });
}

TcpForwarder::~TcpForwarder() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  [[maybe_unused]] const auto written = write(wake_[1], "", 1);
  thread_.join();
  for (const auto& pair : pairs_) {
    close(pair.client);
    close(pair.server);
  }
  close(listener_);
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
      for (const auto& pair : pairs_) {
        close(pair.client);
        close(pair.server);
      }
      pairs_.clear();
    }
    {
      const std::scoped_lock lock(mutex_);
      reached_ = state;
    }
    changed_.notify_all();

    std::vector<pollfd> fds{{wake_[0], POLLIN, 0},
                            {listener_, static_cast<short>(state == State::kStalled ? 0 : POLLIN), 0}};
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
      const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      const int server = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const auto address = Local(target_port_);
      const int one = 1;
      setsockopt(server, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
      setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
      if (state == State::kCut || client < 0 ||
          connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        close(client);
        close(server);
      } else {
        pairs_.push_back({client, server});
      }
      continue;
    }
    std::vector<Pair> kept;
    for (std::size_t i = 0; i < pairs_.size() && 2 * i + 3 < fds.size(); ++i) {
      const Pair pair = pairs_[i];
      const bool alive = (fds[2 + 2 * i].revents == 0 || Pump(pair.client, pair.server)) &&
                         (fds[3 + 2 * i].revents == 0 || Pump(pair.server, pair.client));
      if (alive) {
        kept.push_back(pair);
      } else {
        close(pair.client);
        close(pair.server);
      }
    }
    pairs_ = std::move(kept);
  }
}

}  // namespace hgros::conformance

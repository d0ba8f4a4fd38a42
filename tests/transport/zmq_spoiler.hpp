#pragma once

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "support/await.hpp"
#include "support/relay_port.hpp"

namespace hgros::test {

/// Forwards connections to a tcp endpoint of this host. Once told, it changes something in what one side sends.
class Spoiler {
 public:
  enum class Side { kClient, kServer };
  /// What follows: it cuts the connection, or goes on, also with new connections.
  enum class Then { kCuts, kGoesOn };
  /// Changes some of these bytes. False: they are none of those that are to be changed.
  using How = std::function<bool(std::span<char> bytes)>;

  explicit Spoiler(
      const std::string& target, Side side = Side::kClient, Then then = Then::kCuts,
      How how =
          [](std::span<char> bytes) {
            bytes.back() ^= 1;
            return true;
          })
      : relay_(static_cast<std::uint16_t>(std::stoi(target.substr(target.rfind(':') + 1)))),
        side_(side),
        then_(then),
        how_(std::move(how)),
        thread_([this](const std::stop_token& stop) { Run(stop); }) {}
  [[nodiscard]] std::string endpoint() const { return "tcp://127.0.0.1:" + std::to_string(relay_.port()); }
  void Spoil() { spoils_ = true; }
  [[nodiscard]] bool spoils() const { return spoils_; }
  [[nodiscard]] int connections() const { return connections_; }
  [[nodiscard]] bool done() const { return done_; }

 private:
  void Run(const std::stop_token& stop) {
    pollfd waits{relay_.listener(), POLLIN, 0};
    while (!stop.stop_requested() && !done_) {
      if (poll(&waits, 1, 20) == 0) continue;
      const auto pair = relay_.Accept();
      if (!pair) return;
      ++connections_;
      Forward(stop, *pair);
      done_ = then_ == Then::kCuts;
      Linger(std::chrono::milliseconds(50));
      pair->Close();
    }
  }
  void Forward(const std::stop_token& stop, const RelayPort::Pair& pair) {
    std::array<pollfd, 2> ends{{{pair.client, POLLIN, 0}, {pair.server, POLLIN, 0}}};
    while (!stop.stop_requested()) {
      if (poll(ends.data(), ends.size(), 20) <= 0) continue;
      for (std::size_t i = 0; i < 2; ++i) {
        std::array<char, 65536> bytes{};
        if (ends[i].revents == 0) continue;
        const ssize_t size = recv(ends[i].fd, bytes.data(), bytes.size(), 0);
        if (size <= 0) return;
        const bool spoilt = i == static_cast<std::size_t>(side_) && spoils_ &&
                            how_(std::span(bytes).first(static_cast<std::size_t>(size)));
        if (spoilt) spoils_ = false;
        (void)send(ends[1 - i].fd, bytes.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL);
        if (spoilt && then_ == Then::kCuts) return;
      }
    }
  }

  const RelayPort relay_;
  const Side side_;
  const Then then_;
  const How how_;
  std::atomic<bool> spoils_{false}, done_{false};
  std::atomic<int> connections_{0};
  std::jthread thread_;
};

}  // namespace hgros::test

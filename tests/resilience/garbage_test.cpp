// Nonsense from the network: at a publisher's endpoint, and where a subscriber expects a publisher.
#include <gtest/gtest.h>
#include <zmq.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "resilience/places.hpp"
#include "resilience/worker_process.hpp"
#include "support/seed.hpp"
#include "transport/zmq_places.hpp"

namespace hgros::resilience {
namespace {

using test::Await;
using test::RawSocket;

/// Random bytes, the same for the same seed; the seed is printed.
class Noise {
 public:
  Noise() : random_(test::Seed()) {}
  std::string operator()(std::size_t most_bytes) {
    std::string bytes(Number(most_bytes), '\0');
    for (char& byte : bytes) byte = static_cast<char>(random_());
    return bytes;
  }
  /// A number from 0 to `most`, inclusive.
  std::size_t Number(std::size_t most) { return std::uniform_int_distribution<std::size_t>(0, most)(random_); }

 private:
  std::mt19937 random_;
};

/// A TCP connection to the loopback; -1 if refused.
int Dial(std::uint16_t port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = LoopbackAddress(port);
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  close(fd);
  return -1;
}

/// A TCP server of the loopback.
class Listener {
 public:
  explicit Listener(std::uint16_t port) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const int one = 1;
    setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    const timeval patience{20, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    const sockaddr_in address = LoopbackAddress(port);
    if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || listen(fd_, 8) != 0) {
      throw std::runtime_error("cannot listen");
    }
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  ~Listener() { close(fd_); }

  /// Sends `bytes` to the next connection and closes it; false if none came in time.
  [[nodiscard]] bool Answer(const std::string& bytes) {
    const int fd = accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC);
    if (fd < 0) return false;
    (void)send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    // Read until the peer closes. With unread bytes at close(), the system would reset the connection and drop what
    // was sent.
    shutdown(fd, SHUT_WR);
    char buffer[4096];
    while (recv(fd, buffer, sizeof buffer, 0) > 0) {
    }
    close(fd);
    return true;
  }

 private:
  int fd_;
};

// The greeting of ZMTP 3 without the command after it.
std::string Greeting() { return test::Greeting("XPUB").substr(0, 64); }

TEST(Garbage, AtAPublishersEndpointIsCountedAndDisturbsNoSession) {
  Noise noise;
  const std::uint16_t port = FreePort();
  const WorkerProcess publisher({Publishing(TcpEndpoint(port)), "--out=images"});
  const WorkerProcess subscriber({Subscribing(TcpEndpoint(port)), "--in=images", "--keep-all=64"});
  ASSERT_TRUE(subscriber.Reaches({{"received", 10}})) << publisher << subscriber;
  const std::size_t files = publisher.open_files();

  for (int i = 0; i < 100; ++i) {
    const int fd = Dial(port);
    ASSERT_GE(fd, 0) << publisher;
    const std::string bytes = (i % 2 == 0 ? Greeting() : std::string()) + noise(5000);
    (void)send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    close(fd);
  }
  ASSERT_TRUE(subscriber.Gains("received", 50)) << publisher << subscriber;

  {
    const RawSocket pub(ZMQ_PUB);  // A socket of the wrong kind.
    pub.Connect(TcpEndpoint(port));
    // Sockets of the right kind that send nonsense. Each bad filter ends a connection, so it takes some.
    std::deque<RawSocket> strangers;
    for (int i = 0; i < 8; ++i) strangers.emplace_back(ZMQ_XSUB).Connect(TcpEndpoint(port));
    ASSERT_TRUE(Await([&] {
      pub.Send({noise(300)});
      for (int i = 0; i < 20; ++i) {
        const RawSocket& stranger = strangers[noise.Number(strangers.size() - 1)];
        const std::string bytes = noise(300);
        switch (noise.Number(3)) {
          case 0: stranger.Send({bytes}); break;
          case 1: stranger.Send({"\1" + bytes}); break;
          case 2: stranger.Send({"\2" + bytes}); break;
          default: stranger.Send({"\2" + bytes, noise(300)});
        }
      }
      return publisher["faults"] > 300;
    })) << publisher;
  }
  ASSERT_TRUE(subscriber.Gains("received", 50)) << publisher << subscriber;
  EXPECT_TRUE(publisher.alive());
  EXPECT_EQ(subscriber["gaps"] + subscriber["disorder"] + subscriber["corrupt"] + subscriber["faults"], 0U)
      << subscriber;
  const WorkerProcess late({Subscribing(TcpEndpoint(port)), "--in=images"});
  EXPECT_TRUE(late.Reaches({{"received", 10}})) << publisher << late;
  EXPECT_TRUE(Await([&] { return publisher.open_files() <= files + 4; }))
      << publisher.open_files() << " were " << files;
}

// Thousands of connections per second: random bytes, which look like ZMTP 1.0, and greetings that are cut short.
TEST(Garbage, InManyConnectionsHoldsNoPublisherUp) {
  Noise noise;
  const std::uint16_t port = FreePort();
  const WorkerProcess publisher({Publishing(TcpEndpoint(port)), "--out=images"});
  const WorkerProcess subscriber({Subscribing(TcpEndpoint(port)), "--in=images", "--keep-all=64"});
  ASSERT_TRUE(subscriber.Reaches({{"received", 10}})) << publisher << subscriber;
  std::atomic<int> connections{0};
  const std::jthread flood([&](const std::stop_token& stop) {
    for (const auto end = std::chrono::steady_clock::now() + 2 * test::kPatience;
         !stop.stop_requested() && std::chrono::steady_clock::now() < end; ++connections) {
      const int fd = Dial(port);
      const std::string bytes = noise.Number(1) == 0 ? Greeting().substr(0, noise.Number(63)) : noise(5000);
      (void)send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      close(fd);
    }
  });
  ASSERT_TRUE(Await([&] { return connections > 5000; }, 2 * test::kPatience));
  EXPECT_TRUE(subscriber.Gains("received", 1000)) << publisher << subscriber;
  EXPECT_EQ(subscriber["gaps"] + subscriber["disorder"] + subscriber["corrupt"], 0U) << subscriber;
}

// ZeroMQ itself never connects again after the other side has broken its protocol.
TEST(Garbage, FromABrokenZeroMqPeerDoesNotEndASubscribersAttempts) {
  const std::uint16_t port = FreePort();
  const WorkerProcess subscriber({Subscribing(TcpEndpoint(port), kImpatient), "--in=images"});
  {
    Listener listener(port);
    ASSERT_TRUE(listener.Answer(Greeting().replace(12, 4, "NONE"))) << "another mechanism" << subscriber;
    ASSERT_TRUE(listener.Answer(Greeting() + std::string("\4\1x", 3))) << "a broken command" << subscriber;
    ASSERT_TRUE(listener.Answer(Greeting() + std::string("\6\0", 2))) << "a reserved flag" << subscriber;
  }
  const WorkerProcess publisher({Publishing(TcpEndpoint(port), kImpatient), "--out=images"});
  ASSERT_TRUE(subscriber.Reaches({{"received", 10}})) << publisher << subscriber;
}

TEST(Garbage, FromAPublisherIsCountedAndDoesNotDisturbALaterPublisher) {
  Noise noise;
  const std::uint16_t port = FreePort();
  const WorkerProcess subscriber({Subscribing(TcpEndpoint(port), kImpatient), "--in=images", "--keep-all=64"});

  {
    Listener listener(port);
    for (int i = 0; i < 6; ++i) {
      ASSERT_TRUE(listener.Answer((i % 2 == 0 ? Greeting() : std::string()) + noise(2000))) << i << subscriber;
    }
  }
  EXPECT_TRUE(subscriber.alive()) << subscriber;

  {
    const RawSocket pub(ZMQ_XPUB);
    ASSERT_TRUE(Await([&] { return zmq_bind(pub.get(), TcpEndpoint(port).c_str()) == 0; }));
    std::vector<std::string> topics;
    ASSERT_TRUE(Await([&] {
      for (const std::string& asked : pub.Receive(0)) {
        if (asked.size() > 1 && asked[0] == '\1') topics.push_back(asked.substr(1));
      }
      // Topics that it has subscribed to pass ZeroMQ's filter; noise follows them.
      for (int i = 0; i < 20 && !topics.empty(); ++i) {
        const std::string& topic = topics[noise.Number(topics.size() - 1)];
        std::vector<std::string> frames(1 + noise.Number(4));
        for (std::string& frame : frames) frame = noise(500);
        frames.front() = topic + (i % 2 == 0 ? std::string() : noise(16));
        pub.Send(frames);
      }
      return topics.size() > 1 && subscriber["faults"] > 300;
    })) << subscriber
        << topics.size() << " topics";
  }
  EXPECT_TRUE(subscriber.alive()) << subscriber;
  EXPECT_EQ(subscriber["received"], 0U) << subscriber;

  const WorkerProcess publisher({Publishing(TcpEndpoint(port)), "--out=images", "--await=1", "--count=200"});
  ASSERT_TRUE(subscriber.Reaches({{"received", 200}})) << publisher << subscriber;
  EXPECT_EQ(subscriber["first"], 1U);
  EXPECT_EQ(subscriber["gaps"] + subscriber["disorder"] + subscriber["corrupt"], 0U) << subscriber;
}

}  // namespace
}  // namespace hgros::resilience

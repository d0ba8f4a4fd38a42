// Sessions that find each other by beacons: on a switch that stops multicast, and beside strangers that send datagrams.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "discovery/beacon/beacon_socket.hpp"
#include "discovery/beacon/datagram.hpp"
#include "hgros/base/ids.hpp"
#include "hgros/discovery/beacon.hpp"
#include "hgros/transport/zmq_transport.hpp"
#include "resilience/shm_numbers.hpp"
#include "resilience/worker_process.hpp"
#include "support/cable.hpp"
#include "support/few_descriptors.hpp"

namespace hgros::resilience {
namespace {

using test::Await;
using test::Ip;
using test::Linger;

constexpr auto kLongerThanAnyPatience = std::chrono::milliseconds(6500);
constexpr auto kSameLineAgainAfter = std::chrono::seconds(10);  // The same as in Log::WriteLimited.

/// Two hosts, 10.195.0.1 and 10.195.0.2, and the switch between them: network namespaces named after this process. They
/// are removed at the end. The next test removes those that a killed process has left.
class Switch {
 public:
  Switch() {
    test::RemoveLeftNamespaces();
    ready = Ip("netns add " + bridge_) && Ip("-n " + bridge_ + " link add br0 type bridge mcast_snooping 0") &&
            Ip("-n " + bridge_ + " link set br0 up") && Attach(left, "left", "10.195.0.1/24") &&
            Attach(right, "right", "10.195.0.2/24") && Multicast(true);
  }
  Switch(const Switch&) = delete;
  Switch& operator=(const Switch&) = delete;
  ~Switch() {
    for (const std::string& name : {left, right, bridge_}) (void)Ip("netns del " + name);
  }
  /// Whether the switch passes multicast on. All other packets pass in any case.
  [[nodiscard]] bool Multicast(bool passes) const {
    const std::string flood = std::string(" type bridge_slave mcast_flood ") + (passes ? "on" : "off");
    return Ip("-n " + bridge_ + " link set left" + flood) && Ip("-n " + bridge_ + " link set right" + flood);
  }

  const std::string left = "hgra" + std::to_string(getpid());
  const std::string right = "hgrb" + std::to_string(getpid());
  bool ready = false;

 private:
  [[nodiscard]] bool Attach(const std::string& host, const std::string& port, const std::string& address) const {
    return Ip("netns add " + host) &&
           Ip("link add eth0 netns " + host + " type veth peer name " + port + " netns " + bridge_) &&
           Ip("-n " + bridge_ + " link set " + port + " master br0 up") &&
           Ip("-n " + host + " addr add " + address + " broadcast + dev eth0") &&
           Ip("-n " + host + " link set eth0 up");
  }

  const std::string bridge_ = "hgrs" + std::to_string(getpid());
};

/// A thread that calls a function again and again, until its end.
class Repeating {
 public:
  Repeating(std::chrono::milliseconds period, const std::function<void()>& what)
      : thread_([period, what](const std::stop_token& stop) {
          for (auto next = std::chrono::steady_clock::now(); !stop.stop_requested(); next += period) {
            what();
            Linger(next + period - std::chrono::steady_clock::now());
          }
        }) {}

 private:
  std::jthread thread_;
};

class Lan : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
    network = std::make_unique<Switch>();
    if (!network->ready) GTEST_SKIP() << "no network namespaces with veth and a bridge here";
    test::On(network->left, [&] { stranger.emplace(std::vector<std::string>{}, kBeaconPort); });
  }
  void Start() {
    StartSubscriber();
    StartPublisher();
    ASSERT_TRUE(subscriber->Reaches({{"received", 100}})) << *subscriber << *publisher;
  }
  void StartSubscriber() { subscriber.emplace(With({"--in=images", "--keep-all=64"}), network->right); }
  void StartPublisher() { publisher.emplace(With({"--out=images", "--await=1"}), network->left); }
  /// The stranger announces invented sessions at these endpoints, again and again.
  Repeating Inventing(const std::vector<std::string>& endpoints) {
    std::vector<std::string> datagrams;
    for (const std::string& endpoint : endpoints) {
      Announcement invented;
      invented.session = SessionId::Random();
      invented.endpoints = {endpoint};
      datagrams.push_back(discovery::EncodeDatagram(invented, domain, false));
    }
    return {std::chrono::milliseconds(10), [this, datagrams, next = std::size_t{0}]() mutable {
              for (int i = 0; i < 10; ++i) (void)stranger->Send(datagrams[next++ % datagrams.size()]);
            }};
  }
  void ExpectNothingLost() const {
    EXPECT_TRUE(subscriber->Gains("received", 100)) << *subscriber << *publisher;
    EXPECT_EQ((*subscriber)["gaps"] + (*subscriber)["disorder"] + (*subscriber)["corrupt"], 0U) << *subscriber;
    EXPECT_EQ((*publisher)["missed"], 0U) << *publisher;
  }

  std::unique_ptr<Switch> network;
  const std::string domain = "test-" + SessionId::Random().ToString();
  std::optional<discovery::BeaconSocket> stranger;  // On the left host.
  std::optional<WorkerProcess> subscriber;          // On the right host.
  std::optional<WorkerProcess> publisher;           // On the left host.

 private:
  std::vector<std::string> With(std::vector<std::string> arguments) {
    setenv("HGROS_DOMAIN", domain.c_str(), 1);
    arguments.emplace_back("--config=discovery: {local: false, lan: true}");
    return arguments;
  }
};

TEST_F(Lan, LosesNothingWhileASwitchStopsMulticast) {
  Start();
  const std::size_t lines = subscriber->log_lines() + publisher->log_lines();
  ASSERT_TRUE(network->Multicast(false));
  Linger(std::chrono::seconds(30));
  EXPECT_EQ(subscriber->log_lines() + publisher->log_lines(), lines) << *subscriber << *publisher;
  ExpectNothingLost();
  publisher.reset();  // Without a goodbye.
  EXPECT_TRUE(Await([&] { return (*subscriber)["peers"] == 0; })) << *subscriber;
  ASSERT_TRUE(network->Multicast(true));
  StartPublisher();
  EXPECT_TRUE(subscriber->Gains("received", 100)) << *subscriber << *publisher;
}

TEST_F(Lan, LosesNothingWhenAStrangerSaysGoodbyeInItsName) {
  Start();
  const std::size_t lines = subscriber->log_lines() + publisher->log_lines();
  std::string goodbye;
  // What the publisher sends is heard on its own host, too: the stranger repeats it as a goodbye from that address.
  ASSERT_TRUE(Await([&] {
    std::array<std::byte, discovery::kMaxDatagramBytes> buffer;
    const auto datagram = stranger->Receive(buffer);
    const auto heard = datagram ? discovery::ParseDatagram(datagram->bytes, domain, "10.195.0.1") : std::nullopt;
    if (!heard || heard->peer.pid != publisher->pid()) return false;
    goodbye = discovery::EncodeDatagram(heard->peer, domain, true);
    return true;
  }));
  for (int i = 0; i < 20; ++i) {
    ASSERT_EQ(stranger->Send(goodbye), "");
    Linger(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(subscriber->log_lines() + publisher->log_lines(), lines) << *subscriber << *publisher;
  ExpectNothingLost();
}

TEST_F(Lan, LosesNothingInAFloodOfGarbage) {
  Start();
  const std::size_t lines = subscriber->log_lines() + publisher->log_lines();
  const auto used = subscriber->cpu_time("hgros-beacon");
  {
    const std::string garbage(100, 'x');
    std::atomic<int> sent{0};
    const Repeating flood(std::chrono::milliseconds(2), [&] {
      for (int i = 0; i < 100; ++i) sent += stranger->Send(garbage).empty() ? 1 : 0;
    });
    const auto began = std::chrono::steady_clock::now();
    Linger(kLongerThanAnyPatience);
    constexpr int kFlood = 65'000;  // On a busy machine it lasts longer.
    EXPECT_TRUE(Await([&] { return sent >= kFlood; })) << sent;
    const auto times = 1 + static_cast<std::size_t>((std::chrono::steady_clock::now() - began) / kSameLineAgainAfter);
    EXPECT_LE(subscriber->log_lines() + publisher->log_lines(), lines + 2 * times)
        << "Each may log the flood once." << *subscriber << *publisher;
    const WorkerProcess late({"--in=images", "--config=discovery: {local: false, lan: true}"}, network->right);
    EXPECT_TRUE(late.Reaches({{"received", 10}})) << late << "Sessions still find each other.";
  }
  std::cout << "processor time of the beacon's thread: " << (subscriber->cpu_time("hgros-beacon") - used).count()
            << " ms" << std::endl;
  ExpectNothingLost();
}

TEST_F(Lan, InventedSessionsTakeFewDescriptorsAndDoNotHideARealOne) {
  StartSubscriber();
  ASSERT_TRUE(subscriber->Reaches({{"ready", 1}})) << *subscriber;
  Linger(std::chrono::milliseconds(200));
  const std::size_t files = subscriber->open_files();
  const std::size_t lines = subscriber->log_lines();
  std::vector<std::string> endpoints;
  for (int i = 0; i < 1000; ++i) {
    // Half of them name ports of the stranger's host, which refuses connections; half of them hosts that do not exist.
    endpoints.push_back(i % 2 == 0 ? "tcp://*:" + std::to_string(20000 + i)
                                   : "tcp://10.195.0." + std::to_string(3 + i % 250) + ":" + std::to_string(1000 + i));
  }
  const Repeating inventing = Inventing(endpoints);
  std::size_t most = 0;
  (void)Await(
      [&] {
        most = std::max(most, subscriber->open_files());
        return false;
      },
      std::chrono::seconds(3));
  EXPECT_LE(most, files + 16) << *subscriber;
  std::cout << "descriptors: " << most - files << std::endl;
  EXPECT_LE(subscriber->log_lines(), lines + 1) << *subscriber;
  StartPublisher();
  EXPECT_TRUE(subscriber->Reaches({{"received", 100}}, 2 * test::kPatience)) << *subscriber << *publisher;
}

TEST_F(Lan, InventedSessionsThatAnswerKeepOutNoOtherHost) {
  {
    const test::FewDescriptors few(160);
    StartSubscriber();
    ASSERT_TRUE(subscriber->Reaches({{"ready", 1}})) << *subscriber;
  }
  // 40 endpoints that answer, at another address than the publisher's.
  ASSERT_TRUE(Ip("-n " + network->left + " addr add 10.195.0.3/24 dev eth0"));
  hgros::Log log{[](LogLevel, std::string_view) {}};
  QuietListener listener;
  std::unique_ptr<ZmqTransport> answering;
  ZmqOptions options;
  std::vector<std::string> endpoints;
  for (int i = 0; i < 40; ++i) endpoints.push_back("tcp://10.195.0.3:" + std::to_string(21000 + i));
  for (const std::string& endpoint : endpoints) options.publish.push_back({endpoint, {}});
  test::On(network->left, [&] { answering = MakeZmqTransport(options, listener, log); });
  const std::size_t files = subscriber->open_files();
  const Repeating inventing = Inventing(endpoints);
  constexpr std::size_t kShare = 160 / 16;
  ASSERT_TRUE(Await([&] { return subscriber->open_files() >= files + 4 * kShare; })) << *subscriber;
  StartPublisher();
  EXPECT_TRUE(subscriber->Reaches({{"received", 100}})) << *subscriber << *publisher;
  EXPECT_LE(subscriber->open_files(), files + 4 * (kShare + 4)) << *subscriber;
}

}  // namespace
}  // namespace hgros::resilience

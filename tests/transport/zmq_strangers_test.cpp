// Connections at a publish endpoint that are of no use: too many, and more than there are descriptors for.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <stop_token>

#include "hgros/base/system_limits.hpp"
#include "support/await.hpp"
#include "support/no_descriptors.hpp"
#include "support/relay_port.hpp"
#include "transport/zmq/publish/accepted_connections.hpp"
#include "transport/zmq_places.hpp"

namespace hgros {
namespace {

using test::Await;
using test::IsReached;
using test::Place;
using test::PublishAt;
using test::SubscribeAt;

/// A tcp connection that says nothing.
class Silent {
 public:
  Silent() = default;
  Silent(const Silent&) = delete;
  Silent& operator=(const Silent&) = delete;
  ~Silent() { close(fd_); }
  void Connect(const std::string& endpoint) const {
    const auto port = static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
    const sockaddr_in address = test::LoopbackAddress(port);
    (void)connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  [[nodiscard]] bool Say(std::string_view bytes) const {
    return send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  /// Reads all that the other side sends.
  [[nodiscard]] bool WasClosed() const {
    char bytes[256];
    for (;;) {
      const auto got = recv(fd_, bytes, sizeof bytes, 0);
      if (got <= 0) return got == 0 || errno == ECONNRESET;
    }
  }

 private:
  const int fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
};

// 0, or the errno.
int ConnectTo(int socket, const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, path.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  if (path.front() == '@') address.sun_path[0] = '\0';
  return connect(socket, reinterpret_cast<const sockaddr*>(&address), size) == 0 ? 0 : errno;
}

/// Whether a socket of this name listens. Also true if no file can be opened now.
bool Listens(const std::string& name) {
  std::ifstream all("/proc/net/unix");
  const std::string accepts = " 00010000 ";
  for (std::string line; std::getline(all, line);) {
    if (line.ends_with(" " + name) && line.find(accepts) != std::string::npos) return true;
  }
  return !all.eof();
}

std::chrono::nanoseconds CpuOf(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

// The time of this process.
std::chrono::nanoseconds UsedCpu() { return CpuOf(CLOCK_PROCESS_CPUTIME_ID); }

std::chrono::nanoseconds UsedCpu(std::jthread& thread) {
  clockid_t clock{};
  return pthread_getcpuclockid(thread.native_handle(), &clock) == 0 ? CpuOf(clock) : std::chrono::nanoseconds(0);
}

TEST(ZmqStrangers, MustSpeakZmtp3) {
  const Place publisher(PublishAt());
  // Subscriptions of ZMTP 1.0, for which ZeroMQ takes arbitrary bytes, and of 2.0.
  for (const std::string& spoken :
       {std::string("\1\0\6\0\1scan", 9), std::string("\xff\0\0\0\0\0\0\0\1\x7f\1\2\0\0", 14)}) {
    const Silent old;
    old.Connect(publisher.Bound());
    ASSERT_TRUE(Await([&] { return old.Say(spoken); }));
    EXPECT_TRUE(Await([&] { return old.WasClosed(); })) << spoken.size();
  }
}

class ZmqLackOfDescriptors : public testing::TestWithParam<const char*> {
 protected:
  const test::Folder folder;
  test::Audience all{GetParam() == std::string("path") ? folder.Ipc() : GetParam()};
};

TEST_P(ZmqLackOfDescriptors, LeavesConnectionsAlone) {
  const std::string endpoint = all.endpoint;
  const bool tcp = endpoint.starts_with("tcp");
  const Silent waiting;
  const int knocking = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  for (int round = 0; round < 2; ++round) {
    {
      test::NoDescriptors few(tcp ? 0 : 8);
      if (tcp) waiting.Connect(endpoint);
      ASSERT_TRUE(Await([&] { return all.publisher.Said("limit of open files"); }));
      test::Linger(std::chrono::milliseconds(300));  // Some heartbeats.
      ASSERT_TRUE(tcp || Await([&] { return !std::filesystem::exists(endpoint.substr(6)); })) << "it is hidden";
      few.Fill();
      EXPECT_TRUE(tcp || ConnectTo(knocking, endpoint.substr(6)) != 0);
      all.ExpectMessages();
    }
    EXPECT_TRUE(IsReached(endpoint)) << "it accepts connections again";
    all.ExpectMessages();
  }
  EXPECT_EQ(all.publisher.TimesSaid("limit of open files"), 1);
  close(knocking);
}

INSTANTIATE_TEST_SUITE_P(At, ZmqLackOfDescriptors, testing::Values("tcp://127.0.0.1:*", "path", "ipc://*"),
                         [](const auto& one) {
                           const std::string name = one.param;
                           return name == "path" ? "IpcPath" : name == "ipc://*" ? "AnyIpc" : "Tcp";
                         });

TEST(ZmqStrangers, WaitingConnectionsUseNoCpuWhileNoDescriptorIsFree) {
  Place publisher(PublishAt());
  const std::string endpoint = publisher.Bound();
  std::deque<Silent> waiting(5);
  {
    const test::NoDescriptors none;
    for (const Silent& one : waiting) one.Connect(endpoint);
    EXPECT_TRUE(Await([&] { return publisher.Said("limit of open files"); }));
    EXPECT_TRUE(Await([&] { return std::ranges::all_of(waiting, &Silent::WasClosed); })) << "nothing waits";
    const auto before = UsedCpu();
    const auto began = std::chrono::steady_clock::now();
    test::Linger(std::chrono::milliseconds(1000));
    EXPECT_LT(UsedCpu() - before, (std::chrono::steady_clock::now() - began) / 2);
  }
  EXPECT_TRUE(IsReached(endpoint)) << "it recovers";
  EXPECT_EQ(publisher.TimesSaid("limit of open files"), 1);
}

TEST(ZmqStrangers, ConnectionsUseNoCpuWhileAnotherThreadTakesEachFreeDescriptor) {
  Place publisher(PublishAt());
  const std::string endpoint = publisher.Bound();
  std::deque<Silent> waiting(50);
  {
    test::NoDescriptors none;
    std::jthread greedy([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        none.Fill();
        test::Linger(std::chrono::milliseconds(1));
      }
    });
    const auto before = UsedCpu() - UsedCpu(greedy);
    const auto began = std::chrono::steady_clock::now();
    for (const Silent& one : waiting) {
      one.Connect(endpoint);
      test::Linger(std::chrono::milliseconds(30));
    }
    EXPECT_LT(UsedCpu() - UsedCpu(greedy) - before, (std::chrono::steady_clock::now() - began) / 2);
    EXPECT_EQ(publisher.TimesSaid("limit of open files"), 1);
  }
  EXPECT_TRUE(IsReached(endpoint)) << "it recovers";
}

TEST(ZmqStrangers, AnIpcEndpointIsSafeFromConnectionsOnceFewDescriptorsAreFree) {
  const test::Folder folder;
  const std::string name = "@" + folder.path().string();  // Only closing such a socket keeps connections away.
  for (const std::string& path : {folder.path().string() + "/socket", name}) {
    Place publisher(PublishAt("ipc://" + path));
    const int knocking = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int early = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    ASSERT_EQ(ConnectTo(early, path), 0);
    char greeting = 0;
    ASSERT_EQ(recv(early, &greeting, 1, 0), 1) << "it was accepted";
    {
      test::NoDescriptors few(8);
      ASSERT_TRUE(Await([&] { return publisher.Said("limit of open files"); }));
      ASSERT_TRUE(path != name || Await([&] { return !Listens(name); })) << "ZeroMQ's thread closes it";
      few.Fill();
      EXPECT_NE(ConnectTo(knocking, path), 0);
      EXPECT_EQ(publisher.TimesSaid("limit of open files"), 1);
      EXPECT_EQ(publisher.Said("its connections are closed"), path == name);
    }
    close(knocking);
    close(early);
    EXPECT_TRUE(IsReached("ipc://" + path)) << "it recovers";
  }
}

TEST(ZmqStrangers, AnEndpointThatStopsListeningForgetsItsConnections) {
  const test::Folder folder;
  Place publisher(PublishAt("ipc://@" + folder.path().string()));
  const conformance::Publication out(*publisher.transport, "scan");
  const test::RawSocket plain(publisher.Bound(), "scan");
  ASSERT_TRUE(out.Joined());
  {
    const test::NoDescriptors few(8);
    EXPECT_TRUE(out.Joined(0));
  }
  EXPECT_TRUE(Await([&] {
    (void)plain.Receive(1);  // ZeroMQ subscribes again in there.
    return out.channel->subscriber_count() == 1;
  })) << "it recovers";
}

TEST(ZmqStrangers, ManyConnectionsAtAnIpcEndpointDoNotUseUpAllDescriptors) {
  const test::Folder folder;
  const std::string path = folder.path().string() + "/socket";
  Place publisher(PublishAt("ipc://" + path));
  std::vector<int> all;
  for (int i = 0; i < 300; ++i) all.push_back(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  {
    const test::NoDescriptors few(100);
    for (const int one : all) {
      (void)ConnectTo(one, path);
      test::Linger(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(Await([&] { return publisher.TimesSaid("limit of open files") == 1; }));
    EXPECT_GT(FreeDescriptors(100), 0);
  }
  for (const int one : all) close(one);
  EXPECT_TRUE(IsReached("ipc://" + path)) << "it recovers";
}

TEST(ZmqStrangers, SubscriberNamesAllReasonsForWhichItsConnectionMayBeClosedAtOnce) {
  const test::RelayPort listening(0);
  std::jthread closes([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) listening.Refuse();
  });
  {
    Place subscriber(SubscribeAt("tcp://127.0.0.1:" + std::to_string(listening.port())));
    EXPECT_TRUE(Await([&] { return subscriber.Said("can open no more files, asks for keys, or is not ZeroMQ"); }));
  }
  closes.request_stop();
  shutdown(listening.listener(), SHUT_RDWR);
}

TEST(ZmqStrangers, SubscriberSaysThatItsOwnProcessCanOpenNoFiles) {
  Place subscriber(SubscribeAt("tcp://localhost:9"));
  test::NoDescriptors none;
  EXPECT_TRUE(Await([&] {
    none.Fill();  // ZeroMQ may have closed one.
    return subscriber.Said("this process can open no more files");
  }));
  EXPECT_TRUE(subscriber.Said("No connection to tcp://localhost:9"));
}

TEST(ZmqStrangers, OnlySomeConnectionsOfAnAddressMayBeSilent) {
  Place publisher(PublishAt());
  const std::string endpoint = publisher.Bound();
  constexpr std::size_t kCount = 3 * zmq::AcceptedConnections::kMostSilent;
  std::deque<Silent> all(kCount);
  for (const Silent& one : all) one.Connect(endpoint);
  const auto closed = [&] { return static_cast<std::size_t>(std::ranges::count_if(all, &Silent::WasClosed)); };
  ASSERT_TRUE(
      Await([&] { return closed() >= kCount - zmq::AcceptedConnections::kMostSilent; }, std::chrono::seconds(8)))
      << closed();
  EXPECT_EQ(publisher.TimesSaid("say nothing"), 1);
  // Sessions from the same address are none of these.
  std::deque<Place> sessions;
  for (int i = 0; i < 3; ++i) sessions.emplace_back(SubscribeAt(endpoint));
  while (all.size() > zmq::AcceptedConnections::kMostSilent / 2) all.pop_back();
  EXPECT_TRUE(Await([&] { return publisher.listener.came == 3; }));
  EXPECT_EQ(publisher.listener.gone, 0);
}

}  // namespace
}  // namespace hgros

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <filesystem>

#include "conformance/tcp_forwarder.hpp"
#include "support/await.hpp"
#include "support/error_of.hpp"
#include "support/few_descriptors.hpp"
#include "transport/zmq/endpoint.hpp"
#include "transport/zmq/socket.hpp"
#include "transport/zmq_places.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::Publication;
using conformance::Reception;
using conformance::TextType;
using test::ErrorOf;
using test::Folder;
using test::IsReached;
using test::Place;
using test::PublishAt;
using test::SubscribeAt;

TEST(ZmqEndpoint, AnIpcPathInUseIsNotStolen) {
  Folder folder;
  const Place first(PublishAt(folder.Ipc()));
  EXPECT_THAT(ErrorOf([&] { Place second(PublishAt(folder.Ipc())); }), testing::HasSubstr(folder.Ipc()));
  EXPECT_TRUE(IsReached(folder.Ipc()));
}

/// Leaves a socket in the folder. Its descriptor.
int BindIn(const Folder& folder, int kind) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  (folder / "socket").string().copy(address.sun_path, sizeof address.sun_path - 1);
  const int fd = socket(AF_UNIX, kind | SOCK_CLOEXEC, 0);
  EXPECT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return fd;
}

TEST(ZmqEndpoint, ASocketOfAnotherKindAtAnIpcPathStays) {
  for (const int kind : {SOCK_DGRAM, SOCK_SEQPACKET}) {
    Folder folder;
    const int other = BindIn(folder, kind);
    ASSERT_TRUE(kind == SOCK_DGRAM || listen(other, 1) == 0);
    EXPECT_THAT(ErrorOf([&] { const Place publisher(PublishAt(folder.Ipc())); }),
                testing::HasSubstr("another program"));
    EXPECT_TRUE(std::filesystem::is_socket(folder / "socket"));
    close(other);
  }
}

TEST(ZmqEndpoint, AFileAtAnIpcPathStays) {
  Folder folder;
  folder.Write("socket", "precious");
  EXPECT_THAT(ErrorOf([&] { const Place publisher(PublishAt(folder.Ipc())); }), testing::HasSubstr("not a socket"));
  EXPECT_EQ(folder.Read("socket"), "precious");
}

TEST(ZmqEndpoint, AnIpcPathOfADeadProcessIsTakenOver) {
  Folder folder;
  close(BindIn(folder, SOCK_STREAM));
  const Place publisher(PublishAt(folder.Ipc()));
  EXPECT_TRUE(IsReached(folder.Ipc()));
}

TEST(ZmqEndpoint, ErrorsNameTheEndpointAndTheFix) {
  const Place first(PublishAt());
  const std::string taken = first.Bound();
  EXPECT_THAT(ErrorOf([&] { Place second(PublishAt(taken)); }),
              testing::AllOf(testing::HasSubstr(taken), testing::HasSubstr("another port")));
  EXPECT_THAT(ErrorOf([&] { Place second(PublishAt("ipc:///tmp/" + std::string(200, 'x'))); }),
              testing::HasSubstr("107"));
  EXPECT_THAT(ErrorOf([&] { Place second(PublishAt("ipc:///no/such/folder/socket")); }), testing::HasSubstr("folder"));
  EXPECT_THAT(ErrorOf([&] { Place second(PublishAt("udp://127.0.0.1:1")); }), testing::HasSubstr("udp"));
  EXPECT_THAT(ErrorOf([&] { Place second(SubscribeAt("tcp://")); }), testing::HasSubstr("tcp"));
}

TEST(ZmqEndpoint, IsTcpWithoutAScheme) {
  const Place publisher(PublishAt("127.0.0.1:*"));
  EXPECT_THAT(publisher.Bound(), testing::StartsWith("tcp://127.0.0.1:"));
}

// "[fe80::1%eth0]"; empty: no interface has one.
std::string LinkLocalAddress() {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return {};
  std::string found;
  for (const ifaddrs* one = all; one != nullptr && found.empty(); one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET6 || (one->ifa_flags & IFF_UP) == 0) continue;
    const auto* const address = reinterpret_cast<const sockaddr_in6*>(one->ifa_addr);
    if (!IN6_IS_ADDR_LINKLOCAL(&address->sin6_addr)) continue;
    const int fd = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool usable = bind(fd, one->ifa_addr, sizeof *address) == 0;  // Not while it is tried out.
    close(fd);
    if (!usable) continue;
    std::array<char, INET6_ADDRSTRLEN> text{};
    inet_ntop(AF_INET6, &address->sin6_addr, text.data(), text.size());
    found = "[" + std::string(text.data()) + "%" + one->ifa_name + "]";
  }
  freeifaddrs(all);
  return found;
}

TEST(ZmqEndpoint, MayHaveAnIp6Address) {
  if (!test::HasIp6()) GTEST_SKIP() << "no IPv6 here";
  for (const std::string& address : {std::string("[::1]"), std::string("[::]"), LinkLocalAddress()}) {
    if (address.empty()) continue;
    const Place publisher(PublishAt("tcp://" + address + ":*"));
    const std::string bound = publisher.Bound();
    EXPECT_THAT(bound, testing::StartsWith("tcp://" + address + ":"));
    const std::string port = bound.substr(bound.rfind(':'));
    const Place subscriber(SubscribeAt("tcp://" + (address == "[::]" ? "[::1]" : address) + port));
    EXPECT_TRUE(test::Await([&] { return subscriber.listener.came == 1 && publisher.listener.came == 1; })) << address;
    if (address != "[::]") continue;
    EXPECT_TRUE(IsReached("tcp://127.0.0.1" + port)) << "all addresses, those of IPv4, too";
  }
}

TEST(ZmqEndpoint, ChannelListsLimitChannelsAndMayChangeWhileRunning) {
  Folder folder;
  ZmqOptions options = PublishAt(folder.Ipc());
  options.publish[0].channels = std::vector<std::string>{"open"};
  Place a(std::move(options));
  Place b(SubscribeAt(folder.Ipc()));
  const Publication open_out(*a.transport, "open"), closed_out(*a.transport, "closed");
  const Reception open_in(*b.transport, "open"), closed_in(*b.transport, "closed");
  ASSERT_TRUE(open_out.Joined());
  EXPECT_EQ(closed_out.channel->subscriber_count(), 0u);
  a.transport->SetPublishChannels(folder.Ipc(), std::vector<std::string>{"closed"});
  ASSERT_TRUE(
      Eventually([&] { return closed_in.channel->publisher_count() == 1 && open_in.channel->publisher_count() == 0; }));
  EXPECT_EQ(open_out.channel->subscriber_count(), 0u);
  b.transport->SetSubscribeChannels(folder.Ipc(), std::vector<std::string>{"open"});
  ASSERT_TRUE(closed_out.Joined(0));
  a.transport->SetPublishChannels(folder.Ipc(), std::nullopt);
  ASSERT_TRUE(Eventually([&] { return open_in.channel->publisher_count() == 1; }));
  EXPECT_EQ(closed_in.channel->publisher_count(), 0u);
  EXPECT_THROW(a.transport->SetPublishChannels("ipc:///nowhere", std::nullopt), Error);
}

TEST(ZmqEndpoint, EndpointsMayBeAddedAndRemovedWhileRunning) {
  Folder folder;
  Place a{ZmqOptions{}}, b{ZmqOptions{}};
  const Publication out(*a.transport, "scan");
  const Reception in(*b.transport, "scan");
  for (int round = 0; round < 3; ++round) {
    a.transport->AddPublishEndpoint({folder.Ipc(), std::nullopt});
    b.transport->AddSubscribeEndpoint({folder.Ipc(), std::nullopt, {}});
    ASSERT_TRUE(Eventually([&] { return out.channel->subscriber_count() == 1 && in.channel->publisher_count() == 1; }));
    EXPECT_TRUE(b.transport->RemoveSubscribeEndpoint(folder.Ipc()));
    ASSERT_TRUE(Eventually([&] { return out.channel->subscriber_count() == 0 && in.channel->publisher_count() == 0; }));
    EXPECT_TRUE(a.transport->RemovePublishEndpoint(folder.Ipc()));
    EXPECT_TRUE(Eventually([&] { return a.transport->Peers().empty() && b.transport->Peers().empty(); }));
  }
  EXPECT_FALSE(a.transport->RemovePublishEndpoint(folder.Ipc()));
}

TEST(ZmqEndpoint, ReportsItsEventsInsteadOfLoggingFailuresAndIsFreedWhenItIsRemoved) {
  Folder folder;
  Place b{ZmqOptions{}};
  std::atomic<int> reached{0}, failed{0}, lost{0};
  auto token = std::make_shared<int>();
  const std::weak_ptr<int> alive = token;
  SubscribeEndpoint endpoint{folder.Ipc(), std::nullopt, {}};
  endpoint.on_event = [&reached, &failed, &lost, token](EndpointEvent event, SessionId) {
    ++(event == EndpointEvent::kReached ? reached : event == EndpointEvent::kFailed ? failed : lost);
  };
  token.reset();
  b.transport->AddSubscribeEndpoint(endpoint);
  endpoint.on_event = nullptr;
  EXPECT_TRUE(Eventually([&] { return failed >= 2; }));
  EXPECT_EQ(reached + lost, 0);
  test::Linger(std::chrono::milliseconds(300));
  EXPECT_FALSE(b.Said("No connection to"));
  std::optional<Place> a(PublishAt(folder.Ipc()));
  EXPECT_TRUE(Eventually([&] { return reached == 1; }));
  EXPECT_EQ(lost, 0);
  a.reset();
  EXPECT_TRUE(Eventually([&] { return lost == 1; }));
  EXPECT_TRUE(b.transport->RemoveSubscribeEndpoint(folder.Ipc()));
  EXPECT_TRUE(Eventually([&] { return alive.expired(); }));
  EXPECT_EQ(reached, 1);
}

TEST(ZmqEndpoint, MessagesThatARemovedEndpointHasReceivedAreStillDelivered) {
  Folder folder;
  Place a(PublishAt(folder.Ipc()));
  Place b(SubscribeAt(folder.Ipc())), other(SubscribeAt(folder.Ipc()));
  test::Door first, second;
  const Demand demand{.queue_depth = 100, .credit_messages = 100};
  Publication out(*a.transport, "scan");
  const Reception in(*b.transport, "scan", TextType(), demand, [&](conformance::Sink& sink) {
    sink.answer = Accepted::kRunHere;
    sink.on_run = [&] { (sink.runs == 0 ? first : second).Pass(); };
  });
  const Reception other_in(*other.transport, "scan", TextType(), demand);
  ASSERT_TRUE(Eventually([&] { return out.channel->subscriber_count() == 2 && in.sink.publishers == 1; }));
  ASSERT_EQ(out.Publish("x"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  // These messages wait in ZeroMQ until the first has run, and are then read together.
  for (int i = 0; i < 20; ++i) ASSERT_EQ(out.Publish("x"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return other_in.sink.count() == 21; }));
  test::Linger(std::chrono::milliseconds(100));  // Nothing tells when ZeroMQ has them for this one, too.
  first.Open();
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 2; }));
  EXPECT_TRUE(b.transport->RemoveSubscribeEndpoint(folder.Ipc()));
  EXPECT_EQ(in.sink.publishers, 1u) << "the endpoint ends after its messages were delivered";
  second.Open();
  EXPECT_TRUE(Eventually([&] { return in.sink.publishers == 0; }));
  EXPECT_GT(in.sink.count(), 2u);
  EXPECT_TRUE(Eventually([&] { return b.transport->Peers().empty(); }));
}

TEST(ZmqEndpoint, IsLoggedOncePerOutageIfItCannotBeReached) {
  Folder folder;
  const std::string said = "No connection to " + folder.Ipc() + " for 200 ms: is the other program running";
  Place subscriber(SubscribeAt(folder.Ipc()));
  for (int outage = 1; outage <= 2; ++outage) {
    ASSERT_TRUE(Eventually([&] { return subscriber.TimesSaid(said) == outage; }));
    test::Linger(std::chrono::milliseconds(500));  // Further attempts fail.
    EXPECT_EQ(subscriber.TimesSaid("No connection to"), outage);
    const Place publisher(PublishAt(folder.Ipc()));
    ASSERT_TRUE(Eventually([&] { return subscriber.listener.came == outage; }));
    EXPECT_EQ(subscriber.TimesSaid("Connected to " + folder.Ipc() + "."), outage);
  }
}

TEST(ZmqEndpoint, LogsThatNothingArrivesWhileTheNetworkIsCutAndThatItDoesAgain) {
  Place publisher(PublishAt());
  const std::string bound = publisher.Bound();
  conformance::TcpForwarder cable(static_cast<std::uint16_t>(std::stoi(bound.substr(bound.rfind(':') + 1))));
  Place subscriber(SubscribeAt("tcp://127.0.0.1:" + std::to_string(cable.port())));
  ASSERT_TRUE(Eventually([&] { return subscriber.listener.came == 1 && publisher.listener.came == 1; }));
  cable.Stall();
  for (Place* place : {&publisher, &subscriber}) {
    EXPECT_TRUE(Eventually([&] { return place->Said(" for 200 ms: the network between is cut"); }));
  }
  cable.Resume();
  for (Place* place : {&publisher, &subscriber}) {
    EXPECT_TRUE(Eventually([&] { return place->Said(" arrive again."); }));
  }
}

TEST(ZmqEndpoint, LogsThatTheHostHasNoAddress) {
  Place subscriber(SubscribeAt("tcp://no-such-host.invalid:5553"));
  EXPECT_TRUE(Eventually([&] { return subscriber.Said("the host \"no-such-host.invalid\" has no address ("); }));
  EXPECT_FALSE(subscriber.Said("is the other program running"));
}

TEST(ZmqEndpoint, TellsHostNamesFromAddresses) {
  EXPECT_EQ(zmq::HostNameOf("tcp://robot2:5553"), "robot2");
  for (const char* other :
       {"tcp://192.168.1.7:5553", "tcp://[fe80::1%eth0]:5553", "tcp://*:5553", "ipc:///run/robot"}) {
    EXPECT_EQ(zmq::HostNameOf(other), "") << other;
  }
}

/// Options for two endpoints.
class ZmqTwoEndpoints : public testing::Test {
 protected:
  using Channels = std::optional<std::vector<std::string>>;
  [[nodiscard]] ZmqOptions Publishing(const Channels& first = {}, const Channels& second = {}) const {
    ZmqOptions options;
    options.publish = {{one, first}, {two, second}};
    return options;
  }
  [[nodiscard]] ZmqOptions Subscribing() const {
    ZmqOptions options;
    options.subscribe = {{one, std::nullopt, {}}, {two, std::nullopt, {}}};
    return options;
  }

  const Folder folder;
  const std::string one = folder.Ipc("one");
  const std::string two = folder.Ipc("two");
};

TEST_F(ZmqTwoEndpoints, OfferEachChannelThatIsOnlyAtOneOfThem) {
  Place a(Publishing(std::vector<std::string>{"x"}, std::vector<std::string>{"y"}));
  const Publication x_out(*a.transport, "x"), y_out(*a.transport, "y");
  Place b(Subscribing());
  const Reception x_in(*b.transport, "x"), y_in(*b.transport, "y");
  EXPECT_TRUE(Eventually([&] { return x_in.channel->publisher_count() == 1 && y_in.channel->publisher_count() == 1; }));
}

TEST_F(ZmqTwoEndpoints, CarryAChannelOnceAndItMovesIfItsOwnNoLongerOffersIt) {
  Place a(Publishing());
  Place b(Subscribing());
  Publication out(*a.transport, "scan");
  const Reception in(*b.transport, "scan");
  const auto arrives = [&] {
    const std::size_t before = in.sink.count();
    return Eventually([&] {
      (void)out.Publish("x");
      return in.sink.count() > before;
    });
  };
  const auto is_once = [&] {
    return Eventually([&] { return out.channel->subscriber_count() == 1 && in.channel->publisher_count() == 1; });
  };
  ASSERT_TRUE(out.Joined() && Eventually([&] { return b.listener.came == 1; }));
  ASSERT_TRUE(arrives());
  for (int round = 0; round < 4; ++round) {
    const std::string& shut = round % 2 == 0 ? one : two;
    const std::string& open = round % 2 == 0 ? two : one;
    a.transport->SetPublishChannels(open, std::nullopt);
    a.transport->SetPublishChannels(shut, std::vector<std::string>{});
    ASSERT_TRUE(arrives()) << "round " << round;
    ASSERT_TRUE(is_once());
  }
  a.transport->SetPublishChannels(two, std::nullopt);
  EXPECT_TRUE(a.transport->RemovePublishEndpoint(one));
  ASSERT_TRUE(is_once());
  EXPECT_EQ(b.transport->Peers().size(), 1u);
}

TEST(ZmqEndpoint, RemovingAPublishEndpointReportsRoomAndFewerSubscribers) {
  Folder folder;
  Place a(PublishAt(folder.Ipc()));
  Place b(SubscribeAt(folder.Ipc()));
  Publication out(*a.transport, "scan");
  const Reception in(*b.transport, "scan", TextType(), {.lossless = true, .credit_messages = 1},
                     conformance::HoldCredit);
  ASSERT_TRUE(Eventually([&] { return out.source.subscribers == 1; }));
  ASSERT_EQ(out.Publish("x"), PublishStatus::kOk);
  ASSERT_EQ(out.Publish("x"), PublishStatus::kFull);
  EXPECT_TRUE(a.transport->RemovePublishEndpoint(folder.Ipc()));
  EXPECT_TRUE(Eventually([&] { return out.source.rooms > 0 && out.source.subscribers == 0; }));
  EXPECT_EQ(out.channel->stats().missed, 1U);
  EXPECT_FALSE(a.Said("has gone without confirming")) << "the subscriber has not gone";
}

TEST(ZmqEndpoint, RefusesATypeNameTooLongForTheWire) {
  Folder folder;
  Place a(PublishAt(folder.Ipc()));
  TypeInfo type = TextType();
  type.name = std::string(2000, 'T');
  conformance::Source source;
  conformance::Sink sink;
  EXPECT_THAT(ErrorOf([&] { (void)a.transport->Advertise("scan", type, source); }), testing::HasSubstr("2000 bytes"));
  EXPECT_THAT(ErrorOf([&] { (void)a.transport->Subscribe("scan", type, {}, sink); }), testing::HasSubstr("2000 bytes"));
}

TEST(ZmqEndpoint, ASessionDoesNotHearItself) {
  Folder folder;
  ZmqOptions options = PublishAt(folder.Ipc());
  options.subscribe = {{folder.Ipc(), std::nullopt, {}}};
  Place self(std::move(options));
  Place other(SubscribeAt(folder.Ipc()));
  Publication out(*self.transport, "scan");
  const Reception own(*self.transport, "scan"), in(*other.transport, "scan");
  ASSERT_TRUE(out.Joined());
  ASSERT_EQ(out.Publish("x"), PublishStatus::kOk);
  ASSERT_TRUE(Eventually([&] { return in.sink.count() == 1; }));
  EXPECT_EQ(own.sink.count(), 0u);
}

TEST(ZmqEndpoint, ASessionSubscribesAtHundredsOfEndpoints) {
  constexpr int kEndpoints = 400;
  rlimit files{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &files), 0);
  if (files.rlim_max < 4096) GTEST_SKIP() << "This process may not have the files for " << kEndpoints << " endpoints.";
  const test::FewDescriptors enough(4096);
  Folder folder;
  const Place a(PublishAt(folder.Ipc()));
  ZmqOptions options;
  for (int i = 0; i < kEndpoints; ++i) options.subscribe.push_back({folder.Ipc("none" + std::to_string(i)), {}, {}});
  options.subscribe.push_back({folder.Ipc(), {}, {}});
  const Place b(std::move(options));
  EXPECT_TRUE(Eventually([&] { return b.listener.came == 1; }));
}

TEST(ZmqEndpoint, ASessionWithAllSocketsDoesNotBlameTheLimitOfFiles) {
  constexpr rlim_t kFiles = zmq::kMostSockets + 256;
  rlimit files{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &files), 0);
  if (files.rlim_max < kFiles) GTEST_SKIP() << "This process may not have the files for so many sockets.";
  const test::FewDescriptors enough(kFiles);
  zmq::Context context;
  std::vector<std::unique_ptr<zmq::Socket>> sockets;
  const std::string error = ErrorOf([&] {
    for (int i = 0; i <= zmq::kMostSockets; ++i) sockets.push_back(std::make_unique<zmq::Socket>(context, ZMQ_PAIR));
  });
  EXPECT_THAT(error, testing::HasSubstr("Cannot create a ZeroMQ socket: this session has 16384 already"));
  EXPECT_GE(sockets.size(), zmq::kMostSockets - 8U);
}

}  // namespace
}  // namespace hgros

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include "hgros/base/error.hpp"
#include "support/await.hpp"
#include "support/few_descriptors.hpp"
#include "transport/zmq/endpoint.hpp"
#include "transport/zmq/socket.hpp"
#include "transport/zmq_places.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::TextType;
using test::Folder;
using test::Place;
using test::PublishAt;
using test::SubscribeAt;

std::string ErrorOf(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(ZmqEndpoint, AnIpcPathInUseIsNotStolen) {
  Folder folder;
  const Place first(PublishAt(folder.Ipc()));
  EXPECT_THAT(ErrorOf([&] { Place second(PublishAt(folder.Ipc())); }), testing::HasSubstr(folder.Ipc()));
  Place subscriber(SubscribeAt(folder.Ipc()));
  EXPECT_TRUE(Eventually([&] { return subscriber.listener.came == 1; }));
}

TEST(ZmqEndpoint, ASocketOfAnotherKindAtAnIpcPathStays) {
  for (const int kind : {SOCK_DGRAM, SOCK_SEQPACKET}) {
    Folder folder;
    const std::string endpoint = folder.Ipc();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, endpoint.c_str() + 6, sizeof address.sun_path - 1);
    const int other = socket(AF_UNIX, kind | SOCK_CLOEXEC, 0);
    ASSERT_EQ(bind(other, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    if (kind == SOCK_SEQPACKET) {
      ASSERT_EQ(listen(other, 1), 0);
    }
    EXPECT_THAT(ErrorOf([&] { const Place publisher(PublishAt(endpoint)); }), testing::HasSubstr("another program"));
    EXPECT_TRUE(std::filesystem::is_socket(address.sun_path));
    close(other);
  }
}

TEST(ZmqEndpoint, AFileAtAnIpcPathStays) {
  Folder folder;
  const std::string endpoint = folder.Ipc();
  const std::string path = endpoint.substr(std::string("ipc://").size());
  std::ofstream(path) << "precious";
  EXPECT_THAT(ErrorOf([&] { const Place publisher(PublishAt(endpoint)); }), testing::HasSubstr("not a socket"));
  std::ifstream file(path);
  std::string text;
  file >> text;
  EXPECT_EQ(text, "precious");
}

TEST(ZmqEndpoint, AnIpcPathOfADeadProcessIsTakenOver) {
  Folder folder;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, (folder.path() + "/socket").c_str());
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  close(fd);
  const Place publisher(PublishAt(folder.Ipc()));
  Place subscriber(SubscribeAt(folder.Ipc()));
  EXPECT_TRUE(Eventually([&] { return subscriber.listener.came == 1; }));
}

TEST(ZmqEndpoint, ErrorsNameTheEndpointAndTheFix) {
  const Place first(PublishAt("tcp://127.0.0.1:*"));
  const std::string taken = first.transport->BoundEndpoints().front();
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
  EXPECT_THAT(publisher.transport->BoundEndpoints().front(), testing::StartsWith("tcp://127.0.0.1:"));
}

bool HasIp6() {
  const int fd = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in6 address{};
  address.sin6_family = AF_INET6;
  address.sin6_addr = in6addr_loopback;
  const bool has = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(fd);
  return has;
}

TEST(ZmqEndpoint, MayHaveAnIp6Address) {
  if (!HasIp6()) GTEST_SKIP() << "no IPv6 here";
  for (const std::string address : {"[::1]", "[::]"}) {
    const Place publisher(PublishAt("tcp://" + address + ":*"));
    const std::string bound = publisher.transport->BoundEndpoints().front();
    EXPECT_THAT(bound, testing::StartsWith("tcp://" + address + ":"));
    const std::string port = bound.substr(bound.rfind(':'));
    const Place subscriber(SubscribeAt("tcp://[::1]" + port));
    EXPECT_TRUE(test::Await([&] { return subscriber.listener.came == 1 && publisher.listener.came == 1; })) << address;
    if (address != "[::]") continue;
    const Place other(SubscribeAt("tcp://127.0.0.1" + port));
    EXPECT_TRUE(test::Await([&] { return other.listener.came == 1; })) << "all addresses, those of IPv4, too";
  }
}

TEST(ZmqEndpoint, ChannelListsLimitChannelsAndMayChangeWhileRunning) {
  Folder folder;
  ZmqOptions options = PublishAt(folder.Ipc());
  options.publish[0].channels = std::vector<std::string>{"open"};
  Place a(std::move(options));
  Place b(SubscribeAt(folder.Ipc()));
  conformance::Source source;
  conformance::Sink open_sink, closed_sink;
  const auto open_out = a.transport->Advertise("open", TextType(), source);
  const auto closed_out = a.transport->Advertise("closed", TextType(), source);
  const auto open_in = b.transport->Subscribe("open", TextType(), {}, open_sink);
  const auto closed_in = b.transport->Subscribe("closed", TextType(), {}, closed_sink);
  ASSERT_TRUE(Eventually([&] { return open_out->subscriber_count() == 1; }));
  EXPECT_EQ(closed_out->subscriber_count(), 0u);
  a.transport->SetPublishChannels(folder.Ipc(), std::vector<std::string>{"closed"});
  ASSERT_TRUE(Eventually([&] { return closed_in->publisher_count() == 1 && open_in->publisher_count() == 0; }));
  EXPECT_EQ(open_out->subscriber_count(), 0u);
  b.transport->SetSubscribeChannels(folder.Ipc(), std::vector<std::string>{"open"});
  ASSERT_TRUE(Eventually([&] { return closed_out->subscriber_count() == 0; }));
  a.transport->SetPublishChannels(folder.Ipc(), std::nullopt);
  ASSERT_TRUE(Eventually([&] { return open_in->publisher_count() == 1; }));
  EXPECT_EQ(closed_in->publisher_count(), 0u);
  EXPECT_THROW(a.transport->SetPublishChannels("ipc:///nowhere", std::nullopt), Error);
}

TEST(ZmqEndpoint, EndpointsMayBeAddedAndRemovedWhileRunning) {
  Folder folder;
  Place a{ZmqOptions{}}, b{ZmqOptions{}};
  conformance::Source source;
  conformance::Sink sink;
  const auto out = a.transport->Advertise("scan", TextType(), source);
  const auto in = b.transport->Subscribe("scan", TextType(), {}, sink);
  for (int round = 0; round < 3; ++round) {
    a.transport->AddPublishEndpoint({folder.Ipc(), std::nullopt});
    b.transport->AddSubscribeEndpoint({folder.Ipc(), std::nullopt, {}});
    ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1 && in->publisher_count() == 1; }));
    EXPECT_TRUE(b.transport->RemoveSubscribeEndpoint(folder.Ipc()));
    ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 0 && in->publisher_count() == 0; }));
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
  conformance::Source source;
  conformance::Sink sink, other_sink;
  test::Door first, second;
  sink.answer = Accepted::kRunHere;
  sink.on_run = [&] { (sink.runs == 0 ? first : second).Pass(); };
  const Demand demand{.queue_depth = 100, .credit_messages = 100};
  const auto out = a.transport->Advertise("scan", TextType(), source);
  const auto in = b.transport->Subscribe("scan", TextType(), demand, sink);
  const auto other_in = other.transport->Subscribe("scan", TextType(), demand, other_sink);
  ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 2 && sink.publishers == 1; }));
  PacketHead head;
  head.channel = "scan";
  head.encoding = Encoding::kCustom;
  const auto publish = [&] {
    ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
    out->Commit(head, conformance::Publication::PayloadOf("x"));
  };
  publish();
  ASSERT_TRUE(Eventually([&] { return sink.count() == 1; }));
  // These messages wait in ZeroMQ until the first has run, and are then read together.
  for (int i = 0; i < 20; ++i) publish();
  ASSERT_TRUE(Eventually([&] { return other_sink.count() == 21; }));
  test::Linger(std::chrono::milliseconds(100));  // Nothing tells when ZeroMQ has them for this one, too.
  first.Open();
  ASSERT_TRUE(Eventually([&] { return sink.count() == 2; }));
  EXPECT_TRUE(b.transport->RemoveSubscribeEndpoint(folder.Ipc()));
  EXPECT_EQ(sink.publishers, 1u) << "the endpoint ends after its messages were delivered";
  second.Open();
  EXPECT_TRUE(Eventually([&] { return sink.publishers == 0; }));
  EXPECT_GT(sink.count(), 2u);
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

TEST(ZmqEndpoint, OneOfTwoEndpointsOfAPublisherCarriesAChannel) {
  Folder folder;
  ZmqOptions both;
  both.publish = {{folder.Ipc("one"), std::nullopt}, {folder.Ipc("two"), std::nullopt}};
  Place a(std::move(both));
  ZmqOptions to_both;
  to_both.subscribe = {{folder.Ipc("one"), std::nullopt, {}}, {folder.Ipc("two"), std::nullopt, {}}};
  Place b(std::move(to_both));
  conformance::Source source;
  conformance::Sink sink;
  const auto out = a.transport->Advertise("scan", TextType(), source);
  const auto in = b.transport->Subscribe("scan", TextType(), {}, sink);
  ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1 && b.listener.came == 1; }));
  EXPECT_TRUE(a.transport->RemovePublishEndpoint(folder.Ipc("one")));
  ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1 && in->publisher_count() == 1; }));
  EXPECT_EQ(b.transport->Peers().size(), 1u);
}

TEST(ZmqEndpoint, EachChannelOfAPublisherComesOverTheEndpointThatOffersIt) {
  Folder folder;
  ZmqOptions apart;
  apart.publish = {{folder.Ipc("one"), std::vector<std::string>{"x"}},
                   {folder.Ipc("two"), std::vector<std::string>{"y"}}};
  Place a(std::move(apart));
  conformance::Source source;
  const auto x_out = a.transport->Advertise("x", TextType(), source);
  const auto y_out = a.transport->Advertise("y", TextType(), source);
  ZmqOptions to_both;
  to_both.subscribe = {{folder.Ipc("one"), std::nullopt, {}}, {folder.Ipc("two"), std::nullopt, {}}};
  Place b(std::move(to_both));
  conformance::Sink x_sink, y_sink;
  const auto x_in = b.transport->Subscribe("x", TextType(), {}, x_sink);
  const auto y_in = b.transport->Subscribe("y", TextType(), {}, y_sink);
  EXPECT_TRUE(Eventually([&] { return x_in->publisher_count() == 1 && y_in->publisher_count() == 1; }));
}

TEST(ZmqEndpoint, ChannelMovesToAnotherEndpointIfItsOwnNoLongerOffersIt) {
  Folder folder;
  ZmqOptions both;
  both.publish = {{folder.Ipc("one"), std::nullopt}, {folder.Ipc("two"), std::nullopt}};
  Place a(std::move(both));
  conformance::Source source;
  const auto out = a.transport->Advertise("x", TextType(), source);
  ZmqOptions to_both;
  to_both.subscribe = {{folder.Ipc("one"), std::nullopt, {}}, {folder.Ipc("two"), std::nullopt, {}}};
  Place b(std::move(to_both));
  conformance::Sink sink;
  const auto in = b.transport->Subscribe("x", TextType(), {}, sink);
  PacketHead head;
  head.channel = "x";
  head.encoding = Encoding::kCustom;
  const auto arrives = [&] {
    const std::size_t before = sink.count();
    return Eventually([&] {
      if (out->Reserve() == PublishStatus::kOk) out->Commit(head, conformance::Publication::PayloadOf("x"));
      return sink.count() > before;
    });
  };
  ASSERT_TRUE(arrives());
  for (int round = 0; round < 4; ++round) {
    const std::string shut = folder.Ipc(round % 2 == 0 ? "one" : "two");
    const std::string open = folder.Ipc(round % 2 == 0 ? "two" : "one");
    a.transport->SetPublishChannels(open, std::nullopt);
    a.transport->SetPublishChannels(shut, std::vector<std::string>{});
    ASSERT_TRUE(arrives()) << "round " << round;
    ASSERT_TRUE(Eventually([&] { return in->publisher_count() == 1 && out->subscriber_count() == 1; }));
  }
}

TEST(ZmqEndpoint, RemovingAPublishEndpointReportsRoomAndFewerSubscribers) {
  Folder folder;
  Place a(PublishAt(folder.Ipc()));
  Place b(SubscribeAt(folder.Ipc()));
  conformance::Source source;
  conformance::Sink sink;
  sink.hold_credit = true;
  const auto out = a.transport->Advertise("scan", TextType(), source);
  const auto in = b.transport->Subscribe("scan", TextType(), {.lossless = true, .credit_messages = 1}, sink);
  ASSERT_TRUE(Eventually([&] { return source.subscribers == 1; }));
  PacketHead head;
  head.channel = "scan";
  head.encoding = Encoding::kCustom;
  ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
  out->Commit(head, conformance::Publication::PayloadOf("x"));
  ASSERT_EQ(out->Reserve(), PublishStatus::kFull);
  EXPECT_TRUE(a.transport->RemovePublishEndpoint(folder.Ipc()));
  EXPECT_TRUE(Eventually([&] { return source.rooms > 0 && source.subscribers == 0; }));
  EXPECT_EQ(out->stats().missed, 1U);
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
  conformance::Source source;
  conformance::Sink own_sink, other_sink;
  const auto out = self.transport->Advertise("scan", TextType(), source);
  const auto own = self.transport->Subscribe("scan", TextType(), {}, own_sink);
  const auto in = other.transport->Subscribe("scan", TextType(), {}, other_sink);
  ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
  PacketHead head;
  head.channel = "scan";
  head.type_name = TextType().name;
  head.encoding = Encoding::kCustom;
  ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
  out->Commit(head, conformance::Publication::PayloadOf("x"));
  ASSERT_TRUE(Eventually([&] { return other_sink.count() == 1; }));
  EXPECT_EQ(own_sink.count(), 0u);
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

TEST(ZmqEndpoint, AForkedChildDoesNothingAndTheParentContinues) {
  Folder folder;
  Place a(PublishAt(folder.Ipc()));
  Place b(SubscribeAt(folder.Ipc()));
  conformance::Source source;
  conformance::Sink sink;
  auto out = a.transport->Advertise("scan", TextType(), source);
  const auto in = b.transport->Subscribe("scan", TextType(), {}, sink);
  ASSERT_TRUE(Eventually([&] { return out->subscriber_count() == 1; }));
  PacketHead head;
  head.channel = "scan";
  head.encoding = Encoding::kCustom;
  const pid_t child = fork();
  if (child == 0) {
    const bool refused = out->Reserve() == PublishStatus::kClosed;
    out->Commit(head, conformance::Publication::PayloadOf("x"));
    out.reset();
    a.transport.reset();
    _exit(refused ? 0 : 1);
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  ASSERT_EQ(out->Reserve(), PublishStatus::kOk);
  out->Commit(head, conformance::Publication::PayloadOf("y"));
  ASSERT_TRUE(Eventually([&] { return sink.count() == 1; }));
  EXPECT_EQ(sink.texts().front(), "y");
}

}  // namespace
}  // namespace hgros

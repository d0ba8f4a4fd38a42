// Programs that speak ZeroMQ and take more than their share at a publish endpoint.
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <thread>
#include <vector>

#include "support/await.hpp"
#include "support/few_descriptors.hpp"
#include "support/relay_port.hpp"
#include "support/seed.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq/endpoint.hpp"
#include "transport/zmq/publish/accepted_connections.hpp"
#include "transport/zmq/publish/unfinished_messages.hpp"
#include "transport/zmq/socket.hpp"
#include "transport/zmq_places.hpp"

namespace hgros {
namespace {

using conformance::Eventually;
using conformance::TextType;
using test::Await;
using test::FewDescriptors;
using test::Frame;
using test::Place;
using test::PublishAt;

/// A tcp client that speaks ZMTP as an XSUB socket does, but sends any bytes as fast as it can.
class Client {
 public:
  explicit Client(const std::string& endpoint, const char* from = "127.0.0.1", std::uint16_t from_port = 0)
      : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in own = test::LoopbackAddress(from_port);
    inet_pton(AF_INET, from, &own.sin_addr);
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own), 0);
    const timeval connect_patience{15, 0};
    setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &connect_patience, sizeof connect_patience);
    const auto port = static_cast<std::uint16_t>(std::stoi(endpoint.substr(endpoint.rfind(':') + 1)));
    const sockaddr_in address = test::LoopbackAddress(port);
    if (connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return;
    (void)Send(test::Greeting("XSUB"));
    // ZeroMQ takes messages only after it has sent its own READY.
    const timeval patience{5, 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    std::array<char, 256> theirs{};
    if (recv(fd_, theirs.data(), 66, MSG_WAITALL) == 66) {
      (void)recv(fd_, theirs.data(), static_cast<unsigned char>(theirs[65]), MSG_WAITALL);
    }
  }
  Client(Client&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  Client& operator=(Client&&) = delete;
  ~Client() { close(fd_); }

  /// False if the connection was closed, or the other side has read nothing for 5 s.
  [[nodiscard]] bool Send(std::string_view bytes) const {
    while (!bytes.empty()) {
      pollfd ready{fd_, POLLOUT, 0};
      if (poll(&ready, 1, 5000) <= 0) return false;
      const auto sent = send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && errno != EAGAIN) return false;
      if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  /// Its own port; 0 if it is not connected.
  [[nodiscard]] std::uint16_t port() const {
    sockaddr_in name{};
    socklen_t size = sizeof name;
    if (getpeername(fd_, reinterpret_cast<sockaddr*>(&name), &size) != 0) return 0;
    size = sizeof name;
    getsockname(fd_, reinterpret_cast<sockaddr*>(&name), &size);
    return ntohs(name.sin_port);
  }
  /// Ends the connection with a reset.
  void Reset() {
    const linger at_once{1, 0};
    setsockopt(fd_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    close(std::exchange(fd_, -1));
  }
  /// The next frame.
  [[nodiscard]] std::string Receive() const {
    std::array<unsigned char, 9> head{};
    if (recv(fd_, head.data(), 2, MSG_WAITALL) != 2) return {};
    std::size_t size = head[1];
    if ((head[0] & 2U) != 0) {
      if (recv(fd_, head.data() + 2, 7, MSG_WAITALL) != 7) return {};
      size = 0;
      for (std::size_t i = 1; i < head.size(); ++i) size = size << 8U | head[i];
    }
    std::string frame(size, '\0');
    return recv(fd_, frame.data(), size, MSG_WAITALL) == static_cast<ssize_t>(size) ? frame : std::string();
  }
  /// The next such message: topics, and some others, come before.
  [[nodiscard]] std::optional<wire::Control> ReceiveUntil(bool (wire::Control::*has)() const) const {
    for (int frames = 0; frames < 6; ++frames) {
      auto control = zmq::ParseControl(AsBytes(Receive()));
      if (control && ((*control).*has)()) return control;
    }
    return {};
  }
  /// Becomes a peer of the endpoint. The handshake's number.
  [[nodiscard]] std::uint64_t Greet(SessionId session) const {
    (void)Send(Frame('\1' + zmq::ControlTopic(session)));
    const auto welcome = ReceiveUntil(&wire::Control::has_welcome);
    if (!welcome) return 0;
    auto hello = zmq::ControlFrom(session);
    WriteFacts(OwnFacts(session, "greedy"), *hello.mutable_hello()->mutable_facts());
    hello.mutable_hello()->set_handshake(welcome->welcome().handshake());
    (void)Send(Frame(zmq::UpstreamFrame(hello)));
    return welcome->welcome().handshake();
  }
  /// Reads all that the other side sends.
  [[nodiscard]] bool WasClosed() const {
    char bytes[256];
    for (;;) {
      const auto got = recv(fd_, bytes, sizeof bytes, MSG_DONTWAIT);
      if (got <= 0) return got == 0 || errno != EAGAIN;
    }
  }

 private:
  int fd_;
};

/// The memory of this process, in MiB; 0 with a sanitizer, which keeps what is freed.
std::int64_t UsedMiB() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return 0;
#endif
  std::int64_t all = 0;
  std::int64_t resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * sysconf(_SC_PAGESIZE) >> 20;
}

// A PING command of ZMTP 3.1, for a TTL of 0.
const std::string kPing("\4\7\4PING\0\0", 9);

/// On a busy machine, or with a sanitizer, the publisher takes a while for so many messages. The session is at another
/// address than the clients.
class ZmqLimits : public testing::Test, protected test::Audience {
 protected:
  ZmqLimits() : Audience(test::kAnyPort, "127.0.0.9:0;", std::chrono::seconds(30)) {}
  ~ZmqLimits() override {
    if (HasFailure()) std::ranges::copy(publisher.Lines(), std::ostream_iterator<std::string>(std::cout, "\n"));
  }
  /// Whether the publisher reads the end of what a client has sent: a subscription to the channel `last`.
  [[nodiscard]] bool ReadsLast(const std::string& last = "last") const {
    return conformance::Publication(*publisher.transport, last).Joined();
  }
};

/// Subscriptions to channels with names of 190 bytes, or their ends.
std::string LongTopics(int first, int count, char begins = '\1') {
  std::string frames;
  for (int i = first; i < first + count; ++i) {
    std::string topic = std::to_string(i);
    topic.resize(190, 'x');
    frames += Frame(begins + PlainTopic(topic));
  }
  return frames;
}

constexpr std::int64_t kMostMiB = 150;

// Each would get a Welcome with all channels, and need not read it.
TEST_F(ZmqLimits, AConnectionThatNamesSeveralSessionsIsClosed) {
  const Client client(endpoint);
  ASSERT_TRUE(client.Send(Frame('\1' + zmq::ControlTopic(SessionId{1}))));
  ASSERT_TRUE(client.Send(Frame('\1' + zmq::ControlTopic(SessionId{2}))));
  EXPECT_TRUE(Eventually([&] { return client.WasClosed(); }));
  EXPECT_TRUE(Eventually([&] { return publisher.Said("names several sessions"); }));
  ExpectMessages();
}

TEST_F(ZmqLimits, AConnectionThatSubscribesWithoutAnEndIsClosed) {
  const std::int64_t before = UsedMiB();
  const Client client(endpoint);
  for (int i = 1000; i < 1200 && client.Send(LongTopics(1000 * i, 1000)); ++i) {
  }
  EXPECT_TRUE(Eventually([&] { return client.WasClosed(); }));
  EXPECT_TRUE(Eventually([&] { return publisher.Said("subscribes to too much"); }));
  EXPECT_LT(UsedMiB() - before, kMostMiB);
  ExpectMessages();
  EXPECT_EQ(publisher.TimesSaid("subscribes to too much"), 1);
  EXPECT_EQ(publisher.TimesSaid("subscribes to twice"), 1);
  EXPECT_EQ(publisher.Overruns(), 2u);
}

TEST_F(ZmqLimits, AConnectionThatSubscribesToMoreThanTheLimitIsNamedAndStays) {
  const Client client(endpoint);
  ASSERT_TRUE(client.Send(LongTopics(1'000'000, 6'000) + Frame('\1' + PlainTopic("last"))));
  EXPECT_TRUE(ReadsLast());
  EXPECT_FALSE(client.WasClosed());
  EXPECT_EQ(publisher.TimesSaid("subscribes to too much"), 1);
  EXPECT_EQ(publisher.Overruns(), 1u);
}

// Some kernels refuse that to users without rights.
bool MayFilterSockets() {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sock_filter keeps_all = BPF_STMT(BPF_RET | BPF_K, UINT32_MAX);
  const sock_fprog filter{1, &keeps_all};
  const bool may = setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0;
  close(fd);
  return may;
}

// ZeroMQ would end the process if a connection had an error while its messages wait, and a PING were among them.
TEST_F(ZmqLimits, APingOfAConnectionThatIsResetOrClosedHereEndsNothing) {
  if (!MayFilterSockets()) GTEST_SKIP() << "This kernel refuses socket filters to this user, so ZeroMQ sees resets.";
  std::string frames;
  for (int i = 0; i < 20; ++i) frames += Frame('\1' + PlainTopic("other"));
  for (int i = 0; i < 3; ++i) frames += kPing;
  for (int i = 0; i < test::Rounds(50, 200); ++i) {
    Client client(endpoint);
    ASSERT_TRUE(client.Send(frames));
    client.Reset();
  }
  for (int i = 0; i < test::Rounds(20, 50); ++i) {
    const Client client(endpoint);
    ASSERT_TRUE(client.Send(Frame("\1not a topic") + frames));
    ASSERT_TRUE(Eventually([&] { return client.WasClosed(); }));
  }
  ExpectMessages();
}

// The kernel drops the first reset.
TEST(ZmqReset, OfASubscriberIsNoticedLongBeforeItsTimeIsUp) {
  enum class Then { kPublishes, kIsSilent, kIsStuck };
  const auto notices = [](Then then) {
    Place publisher(PublishAt(), std::chrono::minutes(10));
    conformance::Publication out(*publisher.transport, "scan");
    Client client(publisher.Bound());
    ASSERT_TRUE(client.Send(Frame('\1' + PlainTopic("scan"))));
    ASSERT_TRUE(out.Joined());
    if (then == Then::kIsStuck) {  // It has not read so much.
      for (int i = 0; i < 20; ++i) (void)out.Publish(std::string(1 << 20, 'x'));
      test::Linger(std::chrono::milliseconds(500));
    }
    client.Reset();
    EXPECT_TRUE(Await([&] {
      if (then == Then::kPublishes) (void)out.Publish("go on");
      return out.channel->subscriber_count() == 0;
    })) << static_cast<int>(then);
  };
  std::vector<std::jthread> at_once;
  for (const Then then : {Then::kPublishes, Then::kIsSilent, Then::kIsStuck}) at_once.emplace_back(notices, then);
}

// The kernel sends the end of a closed connection for more than a minute, if nothing answers. Meanwhile a connection
// from the same port cannot be made.
TEST(ZmqReset, LeavesNoPortInUse) {
  const Place publisher(PublishAt());
  const std::string endpoint = publisher.Bound();
  for (int i = 0; i < 10; ++i) {
    Client broken(endpoint);
    const std::uint16_t port = broken.port();
    ASSERT_NE(port, 0);
    ASSERT_TRUE(broken.Send("\2\x7f\xff\xff\xff\xff\xff\xff\xff"));  // Of that size: ZeroMQ closes the connection.
    broken.Reset();
    const Client again(endpoint, "127.0.0.1", port);
    ASSERT_EQ(again.port(), port) << i;
  }
}

TEST_F(ZmqLimits, AStrangerCannotSpeakInTheNameOfASession) {
  auto unsubscribe = zmq::ControlFrom(SessionId{7});
  unsubscribe.mutable_unsubscribe()->set_channel("scan");
  auto bye = zmq::ControlFrom(SessionId{7});
  bye.mutable_bye();
  const std::string forged = Frame(zmq::UpstreamFrame(unsubscribe)) + Frame(zmq::UpstreamFrame(bye));
  const Client stranger(endpoint);
  ASSERT_TRUE(stranger.Send(forged));
  EXPECT_TRUE(Eventually([&] { return publisher.Said(", which has another connection"); }));
  ExpectMessages();
  ASSERT_NE(stranger.Greet(SessionId{7}), 0U);
  EXPECT_TRUE(Eventually([&] { return publisher.Said(", which is another program"); }));
  ASSERT_TRUE(stranger.Send(forged));
  test::Linger(std::chrono::milliseconds(100));
  for (int i = 0; i < 10; ++i) ExpectMessages();
  EXPECT_EQ(publisher.listener.gone, 0);
}

TEST_F(ZmqLimits, AGoodbyeAlsoGoesToASessionThatHasNotAnsweredItsWelcome) {
  const Client client(endpoint);
  ASSERT_TRUE(client.Send(Frame('\1' + zmq::ControlTopic(SessionId{1}))));
  ASSERT_TRUE(client.ReceiveUntil(&wire::Control::has_welcome));
  out.channel.reset();
  publisher.transport.reset();
  EXPECT_TRUE(client.ReceiveUntil(&wire::Control::has_bye));
}

TEST_F(ZmqLimits, AConnectionThatDoesNotReadTheAnswersToItsMessagesIsClosed) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "A million messages take too long with a sanitizer.";
#endif
  const std::int64_t before = UsedMiB();
  const Client client(endpoint);
  const SessionId greedy{99};
  ASSERT_NE(client.Greet(greedy), 0U);
  auto message = zmq::ControlFrom(greedy);
  message.mutable_heartbeat()->set_asked_ns(1);
  std::string frames;
  for (int i = 0; i < 1000; ++i) frames += Frame(zmq::UpstreamFrame(message));
  for (int i = 0; i < 10'000 && client.Send(frames); ++i) {
  }
  EXPECT_TRUE(Await([&] { return publisher.Said("does not read the answers to its messages"); }, 4 * test::kPatience));
  EXPECT_TRUE(Eventually([&] { return publisher.listener.gone == 1; }));
  EXPECT_LT(UsedMiB() - before, 600);
  ExpectMessages();
}

TEST_F(ZmqLimits, AConnectionWhoseSessionAsksForTooMuchIsClosed) {
  const std::int64_t before = UsedMiB();
  const Client client(endpoint);
  const SessionId greedy{99};
  const std::uint64_t handshake = client.Greet(greedy);
  ASSERT_NE(handshake, 0U);
  std::string frames;
  for (int i = 0; i < 16'000; ++i) {
    auto message = zmq::ControlFrom(greedy);
    auto& asked = *message.mutable_subscribe();
    asked.set_handshake(handshake);
    asked.mutable_wanted()->set_channel(std::to_string(1'000'000 + i) + std::string(190, 'x'));
    asked.mutable_wanted()->set_type_name(std::string(1000, 't'));
    frames += Frame(zmq::UpstreamFrame(message));
    if (i % 100 != 99) continue;
    if (!client.Send(frames)) break;
    frames.clear();
  }
  EXPECT_TRUE(Eventually([&] { return client.WasClosed(); }));
  EXPECT_TRUE(Eventually([&] { return publisher.Said("subscribes to twice"); }));
  EXPECT_TRUE(Eventually([&] { return publisher.listener.gone == 1; }));
  EXPECT_LT(UsedMiB() - before, kMostMiB);
  ExpectMessages();
}

// Their links are lossless, so they may come back.
TEST_F(ZmqLimits, SessionsThatComeAndGoCannotLeaveMoreWishesThanAllMayHave) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "So many messages take too long with a sanitizer.";
#endif
  const auto count = [&] {
    std::size_t sum = 0;
    for (const auto& known : publisher.transport->KnownChannels()) sum += known.channels.size();
    return sum;
  };
  constexpr std::size_t kEach = 9'000;  // Of 160 bytes.
  for (unsigned number = 100; number < 108; ++number) {
    const Client client(endpoint);
    const SessionId greedy{number};
    const std::uint64_t handshake = client.Greet(greedy);
    ASSERT_NE(handshake, 0U);
    auto message = zmq::ControlFrom(greedy);
    auto& asked = *message.mutable_subscribe();
    asked.set_handshake(handshake);
    asked.set_lossless(true);
    WriteType("scan", TextType(), *asked.mutable_wanted());
    std::string frames = Frame(zmq::UpstreamFrame(message));
    asked.mutable_wanted()->set_type_name(std::string(1000, 't'));
    for (std::size_t i = 0; i < kEach; ++i) {
      asked.mutable_wanted()->set_channel(std::to_string(1'000'000 + i) + std::string(190, 'x'));
      frames += Frame(zmq::UpstreamFrame(message));
    }
    const std::string name = "last" + std::to_string(number);
    (void)client.Send(frames + Frame('\1' + PlainTopic(name)));
    const conformance::Publication last(*publisher.transport, name);
    ASSERT_TRUE(Eventually([&] { return last.channel->subscriber_count() == 1 || client.WasClosed(); }));
    ASSERT_LT(count(), (zmq::AcceptedConnections::kMostTopicBytesOfAll / 160) + kEach);
  }
  ExpectMessages();
}

TEST_F(ZmqLimits, TheLargestOfConnectionsWithTooManyTopicsTogetherAreClosed) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "ZeroMQ needs seconds to forget so many topics with a sanitizer, and the others fall silent.";
#endif
  const std::int64_t before = UsedMiB();
  std::vector<Client> clients;
  for (int number = 0; number < 6; ++number) {
    const Client& client = clients.emplace_back(endpoint);
    const int first = 10'000'000 + number * 10'000;
    for (int i = 0; i < 9'500; i += 500) (void)client.Send(LongTopics(first + i, 500));  // 1.9 MiB.
  }
  const auto closed = [&] { return std::ranges::count_if(clients, &Client::WasClosed); };
  EXPECT_TRUE(Eventually([&] { return closed() >= 1; })) << closed();
  EXPECT_LT(UsedMiB() - before, 800);
  EXPECT_TRUE(Eventually([&] { return publisher.TimesSaid("are too many together") == 1; }));
  ExpectMessages();
}

TEST_F(ZmqLimits, AConnectionMayWalkThroughTheChannelsThatAnotherOneHolds) {
  const Client recorder(endpoint);
  const Client walker(endpoint, "127.0.0.2");
  const std::string held = LongTopics(1'000'000, 4'000);
  ASSERT_TRUE(recorder.Send(held + Frame('\1' + PlainTopic("held"))));
  ASSERT_TRUE(ReadsLast("held"));
  // Channels of its own make the sum larger than the limit if the others were still counted.
  ASSERT_TRUE(walker.Send(held + LongTopics(1'000'000, 4'000, '\0') + LongTopics(2'000'000, 2'000) +
                          Frame('\1' + PlainTopic("last"))));
  EXPECT_TRUE(ReadsLast());
  EXPECT_FALSE(walker.WasClosed());
  EXPECT_EQ(publisher.Overruns(), 0u);
}

TEST_F(ZmqLimits, AStrangerCannotEndTheSubscriptionsOfOthers) {
  const std::string ends = Frame('\0' + PlainTopic("scan")) + Frame('\0' + zmq::ControlTopic(SessionId{7}));
  { EXPECT_TRUE(Client(endpoint, "127.0.0.2").Send(ends)); }  // It ends at once.
  const Client client(endpoint);
  EXPECT_TRUE(client.Send(ends + Frame('\1' + PlainTopic("last"))));
  EXPECT_TRUE(ReadsLast());
  EXPECT_EQ(out.channel->subscriber_count(), 2u);
  EXPECT_EQ(publisher.listener.gone, 0);
  ExpectMessages();
}

TEST_F(ZmqLimits, ARemovedEndpointLeavesNoDescriptorsOpen) {
  const std::size_t before = conformance::OpenFiles();
  for (int i = 0; i < 20; ++i) {
    publisher.transport->AddPublishEndpoint({"tcp://127.0.0.2:*", std::nullopt});
    EXPECT_TRUE(publisher.transport->RemovePublishEndpoint("tcp://127.0.0.2:*"));
  }
  EXPECT_TRUE(Eventually([&] { return conformance::OpenFiles() < before + 10; })) << conformance::OpenFiles() - before;
}

TEST_F(ZmqLimits, AConnectionMaySubscribeToAsManyChannelsAsThereMayBe) {
  const Client client(endpoint);
  std::string frames;
  for (int i = 0; i < 16'000; ++i) frames += Frame('\1' + PlainTopic("robot/sensors/camera/" + std::to_string(i)));
  // Again and again the same one.
  for (int i = 0; i < 20'000; ++i) {
    const std::string topic = PlainTopic("flapping");
    frames += Frame('\1' + topic) + Frame('\0' + topic);
  }
  ASSERT_TRUE(client.Send(frames + Frame('\1' + PlainTopic("last"))));
  EXPECT_TRUE(ReadsLast());
  EXPECT_FALSE(client.WasClosed());
  ExpectMessages();
  EXPECT_EQ(publisher.Overruns(), 0u);
}

TEST_F(ZmqLimits, AConnectionWhoseMessageDoesNotEndIsClosed) {
  for (const std::size_t bytes : {0u, 200u}) {
    const std::int64_t before = UsedMiB();
    const std::uint64_t overruns = publisher.Overruns();
    const Client client(endpoint);
    std::string frames = Frame("\2a", true);
    ASSERT_TRUE(client.Send(frames));
    frames.clear();
    for (int i = 0; i < 10'000; ++i) frames += Frame(std::string(bytes, 'x'), true);
    for (int i = 0; i < 100 && client.Send(frames); ++i) {
    }
    EXPECT_TRUE(Eventually([&] { return client.WasClosed(); })) << bytes;
    EXPECT_LT(UsedMiB() - before, kMostMiB) << bytes;
    EXPECT_TRUE(Eventually([&] { return publisher.Overruns() == overruns + 1; }));
  }
  ExpectMessages();
  EXPECT_EQ(publisher.TimesSaid("a message that does not end"), 1);
}

TEST_F(ZmqLimits, AConnectionThatSendsManyWholeMessagesStays) {
  const Client client(endpoint);
  std::string frames;
  for (int i = 0; i < 100; ++i) frames += Frame("\2" + std::string(60'000, 'x'));
  ASSERT_TRUE(client.Send(frames + Frame('\1' + PlainTopic("last"))));
  EXPECT_TRUE(ReadsLast());
  test::Linger(std::chrono::milliseconds(200));
  EXPECT_FALSE(client.WasClosed());
}

TEST_F(ZmqLimits, AnAddressMayHaveAQuarterOfTheDescriptors) {
  const FewDescriptors few(400);
  std::vector<Client> clients;
  for (int i = 0; i < 150; ++i) {
    const Client& client = clients.emplace_back(endpoint, "127.0.0.2");
    (void)client.Send(Frame('\1' + PlainTopic("mine")));
  }
  const auto closed = [&] { return std::ranges::count_if(clients, &Client::WasClosed); };
  EXPECT_TRUE(Eventually([&] { return closed() == 50; })) << closed();
  ExpectMessages();
  EXPECT_EQ(publisher.TimesSaid("127.0.0.2"), 1);
  EXPECT_EQ(publisher.Overruns(), 50u);
  const Client other(endpoint, "127.0.0.3");
  test::Linger(std::chrono::milliseconds(100));
  EXPECT_FALSE(other.WasClosed());
  EXPECT_EQ(closed(), 50);
  clients.clear();
  EXPECT_TRUE(Eventually([&] {
    const Client again(endpoint, "127.0.0.2");
    test::Linger(std::chrono::milliseconds(50));
    return !again.WasClosed();
  })) << "an ended connection makes room for another";
}

/// A tcp connection to this process.
struct Pair {
  explicit Pair(const test::RelayPort& at = test::RelayPort(0)) {
    const sockaddr_in address = test::LoopbackAddress(at.port());
    EXPECT_EQ(connect(theirs, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ours = accept4(at.listener(), nullptr, nullptr, SOCK_CLOEXEC);
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  ~Pair() {
    close(theirs);
    close(ours);
  }
  int theirs = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  int ours = -1;
};

TEST(ZmqUnfinishedMessages, AMessageNowAndThenWakesOnce) {
  const Pair pair;
  zmq::UnfinishedMessages unfinished;
  auto now = std::chrono::steady_clock::now();
  unfinished.Add(pair.ours, now);
  std::array<char, 30> message{};
  for (int i = 0; i < test::Rounds(4, 10); ++i) {
    now += std::chrono::milliseconds(150);
    ASSERT_EQ(send(pair.theirs, message.data(), message.size(), 0), static_cast<ssize_t>(message.size()));
    pollfd ready{unfinished.fd(), POLLIN, 0};
    ASSERT_EQ(poll(&ready, 1, 5000), 1) << "the first bytes wake";
    // The message may be delivered before that is noticed.
    if (i % 2 == 0) unfinished.NoteMessage(pair.ours);
    unfinished.input() = true;
    (void)unfinished.IsLookDue();
    ASSERT_EQ(recv(pair.ours, message.data(), message.size(), MSG_WAITALL), static_cast<ssize_t>(message.size()));
    unfinished.NoteMessage(pair.ours);
    unfinished.SettleDelivered(now);
    EXPECT_EQ(poll(&ready, 1, 100), 0) << "no look is needed";
  }
}

TEST(ZmqUnfinishedMessages, AMessageWithoutEndAfterWholeOnesIsFound) {
  const Pair pair;
  zmq::UnfinishedMessages unfinished;
  auto now = std::chrono::steady_clock::now();
  unfinished.Add(pair.ours, now);
  std::vector<char> bytes(40'000);
  bool cut = false;
  constexpr int kWhole = 5;
  for (int i = 0; i < 50 && !cut; ++i) {
    now += i < kWhole ? std::chrono::milliseconds(150) : std::chrono::milliseconds(20);
    ASSERT_EQ(send(pair.theirs, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    pollfd ready{unfinished.fd(), POLLIN, 0};
    ASSERT_EQ(poll(&ready, 1, 5000), 1);
    unfinished.input() = true;
    const bool due = unfinished.IsLookDue();
    ASSERT_EQ(recv(pair.ours, bytes.data(), bytes.size(), MSG_WAITALL), static_cast<ssize_t>(bytes.size()));
    if (i < kWhole) unfinished.NoteMessage(pair.ours);
    if (due) cut = !unfinished.Look(now).empty();
    unfinished.SettleDelivered(now);
    EXPECT_TRUE(!cut || i > kWhole + 4) << "256 KiB are legal";
  }
  EXPECT_TRUE(cut);
}

TEST(ZmqUnfinishedMessages, PingsAreNoMessage) {
  const Pair pair;
  zmq::UnfinishedMessages unfinished;
  const auto start = std::chrono::steady_clock::now();
  unfinished.Add(pair.ours, start);
  std::array<char, 42000> bytes{};  // Encrypted ones every 100 ms have as many in 100 s.
  const auto looked_at = [&](std::chrono::seconds time) {
    EXPECT_EQ(send(pair.theirs, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    EXPECT_TRUE(Eventually([&] {
      unfinished.input() = true;
      return unfinished.IsLookDue();
    }));
    EXPECT_EQ(recv(pair.ours, bytes.data(), bytes.size(), MSG_WAITALL), static_cast<ssize_t>(bytes.size()));
    return unfinished.Look(start + time);
  };
  auto time = std::chrono::seconds(0);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(looked_at(time += std::chrono::seconds(100)).empty()) << i;
  bool cut = false;
  for (int i = 0; i < 100 && !cut; ++i) cut = !looked_at(time).empty();
  EXPECT_TRUE(cut) << "as much at once is a message";
}

/// Connections without descriptors.
class ZmqAcceptedConnections : public testing::Test {
 protected:
  static constexpr int kFirst = 1 << 24;  // No descriptor of a process.

  void Connect(int connection, SessionId session = {}) {
    (void)accepted.Add(connection, "", std::chrono::steady_clock::now());
    if (session.value == 0) return;
    EXPECT_TRUE(accepted.NoteSession(connection, session));
    accepted.NoteProof(connection, session.value);
  }
  /// Subscribes to some 200 bytes. False if it is closed.
  bool Subscribe(int connection, int number) {
    return accepted.CountTopic(connection, std::to_string(connection) + std::to_string(number) + std::string(170, 'x'),
                               true);
  }
  [[nodiscard]] bool IsClosed(int connection) { return !Subscribe(connection, 1'000'000 + next_++); }
  [[nodiscard]] std::ptrdiff_t TimesCut() const { return kept.TimesSaid("too many together"); }
  /// Many connections together subscribe to more than all may, and each to little.
  void ComeInCrowds() {
    for (int i = 1; i <= 1000; ++i) {
      Connect(kFirst + i);
      for (int k = 0; k < 50; ++k) (void)Subscribe(kFirst + i, k);
    }
  }

  conformance::KeptLog kept;
  conformance::Listener listener;
  zmq::SharedState shared{{}, listener, kept.log};
  std::string bound = "tcp://127.0.0.1:1";
  zmq::AcceptedConnections accepted{shared, bound};

 private:
  int next_ = 0;
};

TEST_F(ZmqAcceptedConnections, ManyConnectionsOfAStrangerDoNotEndASession) {
  Connect(kFirst, SessionId{1});
  for (int i = 0; i < 7'500; ++i) ASSERT_TRUE(Subscribe(kFirst, i));  // 1.5 MiB.
  constexpr int kPlain = kFirst + 5000;
  Connect(kPlain);
  ASSERT_TRUE(Subscribe(kPlain, 0));
  ComeInCrowds();
  EXPECT_EQ(TimesCut(), 1);
  EXPECT_FALSE(IsClosed(kFirst));
  EXPECT_FALSE(IsClosed(kPlain)) << "a few topics are not worth it";
}

TEST_F(ZmqAcceptedConnections, SessionsAreCutIfOthersHaveLittle) {
  constexpr int kPlain = kFirst + 5000;
  Connect(kPlain);
  ASSERT_TRUE(Subscribe(kPlain, 0));
  for (int number = 0; number < 6; ++number) {
    Connect(kFirst + number, SessionId{1U + static_cast<unsigned>(number)});
    for (int i = 0; i < 8'000; ++i) (void)Subscribe(kFirst + number, i);
  }
  EXPECT_EQ(TimesCut(), 1);
  EXPECT_FALSE(IsClosed(kPlain));
}

TEST_F(ZmqAcceptedConnections, WishesOfSessionsThatMayComeBackCount) {
  Connect(kFirst, SessionId{1});
  ASSERT_TRUE(accepted.CountWishes(kFirst, SessionId{1}, 1 << 20));
  for (unsigned i = 2; i < 20 && accepted.CollectGivenUp().empty(); ++i) {
    const int connection = kFirst + static_cast<int>(i);
    Connect(connection, SessionId{i});
    ASSERT_TRUE(accepted.CountWishes(connection, SessionId{i}, 3 << 19));
    accepted.Remove(connection);
    ASSERT_LT(i, 10U) << "nothing was given up";
  }
  EXPECT_FALSE(IsClosed(kFirst)) << "it has less";
}

TEST_F(ZmqAcceptedConnections, WishesOfDroppedSessionsDoNotCount) {
  for (unsigned i = 2; i < 20; ++i) {
    Connect(kFirst, SessionId{i});
    ASSERT_TRUE(accepted.CountWishes(kFirst, SessionId{i}, 3 << 19));
    accepted.Remove(kFirst);
    accepted.ForgetWishes(SessionId{i});
    ASSERT_TRUE(accepted.CollectGivenUp().empty());
  }
}

// The system gives the descriptor of a connection that has ended to the next one, before its last message is read.
TEST_F(ZmqAcceptedConnections, TheLastMessageOfAConnectionIsItsOwnWhenItsNumberIsUsedAgain) {
  constexpr SessionId kGone{1};
  constexpr std::uint64_t kItsProof = 77;
  const auto come = [&] {
    ASSERT_TRUE(accepted.Add(kFirst, "10.0.0.1", std::chrono::steady_clock::now()));
    ASSERT_TRUE(accepted.NoteSession(kFirst, kGone));
    accepted.NoteProof(kFirst, kItsProof);
  };
  come();
  ASSERT_TRUE(accepted.Add(kFirst, "10.0.0.2", std::chrono::steady_clock::now()));
  EXPECT_TRUE(accepted.MaySpeakFor(kFirst, kGone, kItsProof));
  EXPECT_FALSE(accepted.MaySpeakFor(kFirst, kGone, kItsProof + 1));
  EXPECT_FALSE(accepted.MaySpeakFor(kFirst, SessionId{2}, kItsProof));
  ASSERT_TRUE(accepted.CountTopic(kFirst, "x", true));
  EXPECT_FALSE(accepted.MaySpeakFor(kFirst, kGone, kItsProof)) << "the next one speaks by now";
  accepted.Remove(kFirst);

  come();
  accepted.Remove(kFirst);
  ASSERT_TRUE(accepted.Add(kFirst, "10.0.0.2", std::chrono::steady_clock::now() - std::chrono::seconds(2)));
  EXPECT_FALSE(accepted.MaySpeakFor(kFirst, kGone, kItsProof)) << "it had time to be read";
}

TEST_F(ZmqAcceptedConnections, AConnectionThatSubscribesToNothingIsClosed) {
  const test::RelayPort listening(0);
  bound = "tcp://127.0.0.1:" + std::to_string(listening.port());
  const auto start = std::chrono::steady_clock::now();
  const Pair idle(listening), plain(listening), session(listening);
  for (const Pair* pair : {&idle, &plain, &session}) ASSERT_TRUE(accepted.Add(pair->ours, "127.0.0.1", start));
  EXPECT_TRUE(accepted.CountTopic(plain.ours, PlainTopic("scan"), true));
  EXPECT_TRUE(accepted.NoteSession(session.ours, SessionId{1}));
  const auto closed = [&](const Pair& pair) {  // ZeroMQ reads the end, and closes it.
    char byte = 0;
    return recv(pair.ours, &byte, 1, MSG_DONTWAIT) == 0;
  };
  accepted.CloseIdle(start + zmq::AcceptedConnections::kIdleAfter - std::chrono::seconds(1));
  EXPECT_FALSE(closed(idle));
  accepted.CloseIdle(start + zmq::AcceptedConnections::kIdleAfter);
  EXPECT_TRUE(Eventually([&] { return closed(idle); }));
  accepted.CloseIdle(start + std::chrono::hours(100));
  EXPECT_FALSE(closed(plain));
  EXPECT_FALSE(closed(session));
  ASSERT_EQ(kept.Lines().size(), 1u);
  EXPECT_NE(kept.Lines()[0].find("127.0.0.1"), std::string::npos) << kept.Lines()[0];
}

// ZeroMQ would wait without a limit for a connection that breaks at the same moment and has messages left, if a socket
// had no limit when it was bound.
TEST(ZmqBrokenConnections, DoNotHoldUpTheEndOfTheirSocket) {
  for (int round = 0; round < test::Rounds(10, 50); ++round) {
    auto context = std::make_unique<zmq::Context>();
    zmq::Socket publisher(*context, ZMQ_XPUB);
    publisher.Set(ZMQ_XPUB_VERBOSER, 1);
    zmq::BindOrThrow(publisher, "tcp://127.0.0.1:*");
    std::vector<Client> subscribers;
    zmq::Message asked;
    for (int i = 0; i < 12; ++i) {
      ASSERT_TRUE(subscribers.emplace_back(publisher.LastEndpoint()).Send(Frame("\1")));
      ASSERT_TRUE(Eventually([&] { return publisher.Receive(asked); }));
    }
    const std::string large(1 << 20, 'x');
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(publisher.Send(large, false));
    std::atomic<bool> ended{false};
    std::thread end([&] {
      publisher.Close(100);
      context.reset();
      ended = true;
    });
    subscribers.clear();
    const bool in_time = Await([&] { return ended.load(); });
    if (!in_time) std::cout << "The context did not end in round " << round << ".\n" << std::flush;
    if (!in_time) std::abort();  // The thread waits for ever.
    end.join();
  }
}

}  // namespace
}  // namespace hgros

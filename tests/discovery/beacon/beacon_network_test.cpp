// Beacons of two hosts: network namespaces with a virtual cable between them.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "discovery/listening.hpp"
#include "hgros/discovery/beacon.hpp"
#include "support/cable.hpp"

namespace hgros::discovery {
namespace {

using std::chrono::milliseconds;
using test::Await;
using test::Cable;
using test::Ip;
using test::On;

struct RemoteParticipant : Participant {
  RemoteParticipant(const std::string& host, const BeaconOptions& options, const std::string& endpoint)
      : Participant([&](auto& listener, Log& kept) {
          std::unique_ptr<Discovery> opened;
          On(host, [&] { opened = OpenBeacon(options, listener, kept); });
          return opened;
        }) {
    own.endpoints = {endpoint};
    Announce();
  }
  /// Waits until it sees exactly one session, at this endpoint.
  [[nodiscard]] bool Finds(const Participant& other, const std::string& endpoint) const {
    return Await([&] {
      const auto all = discovery->List();
      return all.size() == 1 && all[0].session == other.own.session && all[0].endpoints == std::vector{endpoint};
    });
  }
};

void ExpectThatTheyFindEachOther(const RemoteParticipant& left, const RemoteParticipant& right) {
  EXPECT_TRUE(left.Finds(right, "tcp://10.198.0.2:6666"));
  EXPECT_TRUE(right.Finds(left, "tcp://10.198.0.1:5555"));
}

class BeaconNetwork : public testing::Test {
 protected:
  void SetUp() override {
    if (geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
    cable = std::make_unique<Cable>();
    if (!cable->ready) GTEST_SKIP() << "no network namespaces with veth here";
  }

  std::unique_ptr<Cable> cable;
  const BeaconOptions options{.domain = "robot"};
};

TEST_F(BeaconNetwork, LetsHostsFindEachOtherAtTheAddressesOfTheirDatagramsWithAndWithoutMulticast) {
  for (const char* how : {"up", "multicast off"}) {  // Without it they use broadcast.
    SCOPED_TRACE(how);
    ASSERT_TRUE(cable->Set(how));
    const RemoteParticipant one(cable->left, options, "tcp://*:5555");
    const RemoteParticipant two(cable->right, options, "tcp://*:6666");
    ExpectThatTheyFindEachOther(one, two);
  }
}

TEST_F(BeaconNetwork, UsesInterfacesThatAppearLater) {
  const BeaconOptions impatient{.domain = "robot", .period = milliseconds(50), .patience = milliseconds(500)};
  const RemoteParticipant one(cable->left, impatient, "tcp://*:5555");
  const RemoteParticipant two(cable->right, impatient, "tcp://*:6666");
  EXPECT_TRUE(one.discovery->List().empty());
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(cable->Set("up"));
    ExpectThatTheyFindEachOther(one, two);
    ASSERT_TRUE(cable->Set("down"));
    EXPECT_TRUE(one.listening.AwaitCount(0));
    EXPECT_TRUE(two.listening.AwaitCount(0));
  }
}

TEST_F(BeaconNetwork, UsesANamedInterfaceThatAppearsLaterAndLogsOnceThatItIsMissing) {
  ASSERT_TRUE(cable->Set("up"));
  const BeaconOptions named{.domain = "robot", .interfaces = {"late0"}, .period = milliseconds(50)};
  const RemoteParticipant one(cable->left, options, "tcp://*:5555");
  const RemoteParticipant two(cable->right, named, "tcp://*:6666");
  EXPECT_TRUE(Await([&] { return two.log.Count({"There is no network interface \"late0\""}) == 1; }));
  EXPECT_TRUE(one.discovery->List().empty());
  const std::string right = "-n " + cable->right + " link set ";
  ASSERT_TRUE(Ip(right + cable->right_interface + " down") && Ip(right + cable->right_interface + " name late0") &&
              Ip(right + "late0 up"));
  ExpectThatTheyFindEachOther(one, two);
  EXPECT_EQ(two.log.Count({"late0"}), 1U);
}

TEST_F(BeaconNetwork, LogsOnceThatAnInterfaceHasNeitherMulticastNorBroadcast) {
  if (!Ip("-n " + cable->right + " tuntap add dev vpn0 mode tun")) GTEST_SKIP() << "no tunnels here";
  ASSERT_TRUE(Ip("-n " + cable->right + " addr add 10.199.0.1/24 dev vpn0") &&
              Ip("-n " + cable->right + " link set vpn0 multicast off up"));
  const BeaconOptions often{.domain = "robot", .period = milliseconds(50)};
  const RemoteParticipant one(cable->right, often, "tcp://*:5555");
  EXPECT_TRUE(Await([&] { return one.log.Count({"\"vpn0\""}) == 1; }));
  test::Linger(milliseconds(300));
  EXPECT_EQ(one.log.Count({"\"vpn0\""}), 1U);
}

TEST_F(BeaconNetwork, UsesOnlyTheChosenInterfaces) {
  ASSERT_TRUE(cable->Set("up"));
  ASSERT_TRUE(Ip("-n " + cable->right + " link set lo up"));
  const BeaconOptions loopback{.domain = "robot", .interfaces = {"lo"}};
  const RemoteParticipant one(cable->left, options, "tcp://*:5555");
  const RemoteParticipant deaf(cable->right, loopback, "tcp://*:6666");
  const RemoteParticipant two(cable->right, options, "tcp://*:7777");
  EXPECT_TRUE(one.Finds(two, "tcp://10.198.0.2:7777"));
  EXPECT_TRUE(deaf.discovery->List().empty());
}

TEST_F(BeaconNetwork, SendsNothingBeyondARouter) {
  ASSERT_TRUE(cable->Set("up"));
  int listener = -1;
  On(cable->right, [&] {
    listener = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int on = 1;
    setsockopt(listener, IPPROTO_IP, IP_RECVTTL, &on, sizeof on);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(kBeaconPort);
    EXPECT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ip_mreqn group{};
    group.imr_multiaddr.s_addr = htonl(0xefff4847);
    group.imr_address.s_addr = htonl(0x0ac60002);
    EXPECT_EQ(setsockopt(listener, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group), 0);
  });
  const BeaconOptions often{.domain = "robot", .period = milliseconds(50)};
  const RemoteParticipant one(cable->left, often, "tcp://*:5555");
  int time_to_live = -1;
  EXPECT_TRUE(Await([&] {
    char bytes[2000];
    alignas(cmsghdr) char control[64];
    iovec piece{bytes, sizeof bytes};
    msghdr message{};
    message.msg_iov = &piece;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    if (recvmsg(listener, &message, 0) <= 0) return false;
    const cmsghdr* header = CMSG_FIRSTHDR(&message);
    if (header != nullptr) time_to_live = *reinterpret_cast<const int*>(CMSG_DATA(header));
    return true;
  }));
  EXPECT_EQ(time_to_live, 1);
  close(listener);
}

}  // namespace
}  // namespace hgros::discovery

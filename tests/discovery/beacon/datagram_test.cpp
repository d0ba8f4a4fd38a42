#include "discovery/beacon/datagram.hpp"

#include <gtest/gtest.h>

#include "discovery/listening.hpp"
#include "hgros/announcement.pb.h"
#include "hgros/base/error.hpp"

namespace hgros::discovery {
namespace {

constexpr const char* kSender = "192.0.2.7";

TEST(Datagram, ContainsSessionAndEndpointsButNothingLocalToTheHost) {
  Announcement own = NewAnnouncement();
  own.endpoints = {"ipc:///run/bus",       "tcp://*:5555",         "tcp://0.0.0.0:5556",   "tcp://127.0.0.1:5557",
                   "tcp://localhost:5558", "tcp://192.0.2.9:5559", "tcp://robot.lan:5560", "tcp://[::1]:5561"};
  const std::string bytes = EncodeDatagram(own, "robot", false);
  const auto heard = ParseDatagram(AsBytes(bytes), "robot", kSender);
  ASSERT_TRUE(heard);
  EXPECT_FALSE(heard->ends);
  Announcement expected;
  expected.session = own.session;
  expected.incarnation = own.incarnation;
  expected.process = own.process;
  expected.host = own.host;
  expected.pid = own.pid;
  expected.sender = kSender;
  expected.endpoints = {"tcp://192.0.2.7:5555", "tcp://192.0.2.7:5556", "tcp://192.0.2.9:5559"};
  EXPECT_EQ(heard->peer, expected);
  const auto goodbye = ParseDatagram(AsBytes(EncodeDatagram(own, "robot", true)), "robot", kSender);
  EXPECT_TRUE(goodbye && goodbye->ends);
}

TEST(Datagram, OfOtherDomainsVersionsAndProgramsIsIgnored) {
  const std::string bytes = EncodeDatagram(NewAnnouncement(), "robot", false);
  EXPECT_FALSE(ParseDatagram(AsBytes(bytes), "other", kSender));
  EXPECT_FALSE(ParseDatagram({}, "robot", kSender));
  EXPECT_FALSE(ParseDatagram(AsBytes("garbage"), "robot", kSender));
  EXPECT_FALSE(ParseDatagram(AsBytes(std::string(kMaxDatagramBytes + 1, '\0')), "robot", kSender));
  wire::BeaconDatagram datagram;
  ASSERT_TRUE(datagram.ParseFromString(bytes));
  const auto is_heard = [&] {
    return ParseDatagram(AsBytes(datagram.SerializeAsString()), "robot", kSender).has_value();
  };
  EXPECT_TRUE(is_heard());
  datagram.set_version(kDatagramVersion + 1);
  EXPECT_FALSE(is_heard());
  datagram.set_version(kDatagramVersion);
  datagram.set_magic(1);
  EXPECT_FALSE(is_heard());
  datagram.set_magic(kDatagramMagic);
  datagram.set_session(0);
  EXPECT_FALSE(is_heard());
}

TEST(Datagram, DropsEndpointsThatAreInvalidOrHaveNamesOrAddressesOfThisHost) {
  wire::BeaconDatagram datagram;
  ASSERT_TRUE(datagram.ParseFromString(EncodeDatagram(NewAnnouncement(), "robot", false)));
  const auto heard = [&] { return ParseDatagram(AsBytes(datagram.SerializeAsString()), "robot", kSender); };
  for (const char* const bad : {"",
                                "tcp://",
                                "tcp://a",
                                "tcp://a:",
                                "tcp://a:0",
                                "tcp://a:65536",
                                "tcp://a:99999999999",
                                "tcp://a:-1",
                                "tcp://:1",
                                "ipc:///etc/passwd",
                                "tcp://a;b:1",
                                "tcp://a/b:1",
                                "tcp://a\n:1",
                                "tcp://a b:1",
                                "tcp://**:1",
                                "tcp://a:1",
                                "tcp://a.name:1",
                                "tcp://localhost:1",
                                "tcp://127.0.0.1:1",
                                "tcp://0.0.0.0:1",
                                "tcp://0.1.2.3:1",
                                "tcp://224.0.0.1:1",
                                "tcp://255.255.255.255:1",
                                "tcp://192.0.2:1",
                                "tcp://192.0.2.256:1",
                                "tcp://1:1",
                                "tcp://0x7f.1:1"}) {
    datagram.clear_endpoints();
    datagram.add_endpoints(bad);
    datagram.add_endpoints("tcp://192.0.2.9:65535");
    ASSERT_TRUE(heard()) << bad;
    EXPECT_EQ(heard()->peer.endpoints, std::vector<std::string>{"tcp://192.0.2.9:65535"}) << bad;
  }
  while (datagram.endpoints_size() < 16) datagram.add_endpoints("tcp://192.0.2.9:1");
  EXPECT_TRUE(heard());
  datagram.add_endpoints("tcp://192.0.2.9:1");
  EXPECT_FALSE(heard()) << "too many";
}

TEST(Datagram, RefusesToWriteWhatCannotBeRead) {
  Announcement own = NewAnnouncement();
  own.session = {};
  EXPECT_THROW((void)EncodeDatagram(own, "robot", false), Error);
  own = NewAnnouncement();
  own.endpoints.assign(17, "tcp://192.0.2.9:1");
  EXPECT_THROW((void)EncodeDatagram(own, "robot", false), Error);
}

}  // namespace
}  // namespace hgros::discovery

#include "transport/shm/pair_inbox.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <memory>
#include <string>

#include "conformance/transport_conformance.hpp"
#include "transport/shm/memory/lane_writer.hpp"

namespace hgros::shm {
namespace {

// The subscriber had no memory for the payload.
TEST(ShmPairInbox, LastMessageEndsItsLinkEvenIfItIsLost) {
  std::string fault;
  int ends[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
  const Handle far_end(ends[1]);
  SessionBell bell{Patience{}};
  const auto slip = Slip::Make(std::make_shared<const Handle>(ends[0]), std::make_shared<const ForkGuard>(), fault);
  const auto writer = LaneWriter::Make(fault);
  ASSERT_TRUE(writer->Open(*slip->handle(), fault)) << fault;
  PairInbox inbox(slip);
  inbox.Open(LaneReader::Open(*writer->handle(), fault), PeerBell::Open(*bell.handle(), 0, fault), SessionId{1});

  const Demand demand{.credit_messages = 4, .credit_bytes = 1000};
  conformance::Sink sink;
  const auto link = inbox.AddLink(std::make_shared<InboundCore>("scan", conformance::TextType(), demand, sink));
  inbox.RaiseLimits(*link, demand);
  wire::Granted granted;
  granted.set_credit_messages(4);
  granted.set_credit_bytes(1000);
  ASSERT_TRUE(inbox.Grant(*link, granted, nullptr));
  ASSERT_TRUE(inbox.AddPayload({link->link, 1, {}}));
  EXPECT_FALSE(inbox.EndAfter(link->link, 1));
  Descriptor last{};
  last.link = link->link;
  last.number = 1;
  last.segment = kOnSocket;
  last.size_bytes = 100;
  writer->Write(last, nullptr);
  PairInbox::Arrival arrival;
  EXPECT_EQ(inbox.Next(arrival, 1000), PairInbox::Step::kLost);
  EXPECT_TRUE(arrival.ends);
}

}  // namespace
}  // namespace hgros::shm

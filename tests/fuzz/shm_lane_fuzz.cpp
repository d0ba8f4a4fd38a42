// All data that a session reads from a peer: frames, descriptors of messages, segments, and the page of counts. The
// input drives a handmade peer, connected to a session of this process.
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include "hgros/transport/shm_transport.hpp"
#include "transport/shm/false_peer.hpp"

namespace {

using namespace hgros;
using shm::FalsePeer;

/// Reads every byte of its input.
class Reader : public InboundSink {
 public:
  Accepted Accept(InboundMessage&& message) noexcept override {
    std::size_t sum = 0;
    for (const std::byte one : message.data.bytes) sum += std::to_integer<std::size_t>(one);
    sum_ = sum;
    return Accepted::kNothing;
  }
  void Run() noexcept override {}
  void OnFault(PacketFault, std::string_view) noexcept override {}
  void OnPublishers(std::size_t) noexcept override {}

 private:
  std::atomic<std::size_t> sum_{0};
};

class Source : public OutboundSource {
 public:
  std::vector<OutboundMessage> Latched(SessionId /*subscriber*/) noexcept override { return {{{}, {}}}; }
  void OnRoom() noexcept override {}
  void OnSubscribers(std::size_t) noexcept override {}
};

class Nobody : public TransportListener {
 public:
  void OnPeerCame(const PeerInfo&) noexcept override {}
  void OnPeerGone(const PeerInfo&, std::string_view) noexcept override {}
  void OnTypeMismatch(std::string_view, const PeerInfo&, std::string_view) noexcept override {}
};

const TypeInfo& Type() {
  static const TypeInfo type = [] {
    TypeInfo made;
    made.name = "fuzz.Text";
    made.encoding = Encoding::kCustom;
    return made;
  }();
  return type;
}

struct Session {
  Session() {
    ShmOptions options;
    options.heartbeat = std::chrono::milliseconds(20);
    options.limit_bytes = 1 << 20;
    transport = MakeShmTransport(options, nobody, log);
    outbound = transport->Advertise("news", Type(), source);
    inbound = transport->Subscribe("lies", Type(), {.credit_messages = 8, .credit_bytes = 4096}, sink);
  }
  Log log{[](LogLevel, std::string_view) {}};
  Nobody nobody;
  Source source;
  Reader sink;
  std::unique_ptr<ShmTransport> transport;
  std::unique_ptr<OutboundChannel> outbound;
  std::unique_ptr<InboundChannel> inbound;
};

/// Takes values off the input. Zeros when it is used up.
struct Input {
  template <class Value>
  Value Take() {
    Value value{};
    const std::size_t count = std::min(size, sizeof value);
    std::memcpy(&value, data, count);
    data += count;
    size -= count;
    return value;
  }
  const std::uint8_t* data;
  std::size_t size;
};

void Step(FalsePeer& peer, Input& input) {
  switch (input.Take<std::uint8_t>() % 6) {
    case 0: {
      auto next = peer.NextMessage();
      next.segment = input.Take<std::uint8_t>() % 3;
      next.offset_bytes = input.Take<std::uint16_t>();
      next.size_bytes = input.Take<std::uint16_t>();
      peer.Write(next);
      break;
    }
    case 1: {
      auto any = input.Take<shm::Descriptor>();
      if ((any.reserved[0] & 1) != 0) any.link = peer.wish.link();
      peer.Write(any);
      break;
    }
    case 2: {
      const std::size_t size = std::min<std::size_t>(input.Take<std::uint8_t>(), input.size);
      peer.SayRaw(std::string(reinterpret_cast<const char*>(input.data), size));
      input.data += size;
      input.size -= size;
      break;
    }
    case 3: {
      const std::size_t size = std::min<std::size_t>(input.Take<std::uint8_t>(), input.size);
      wire::PairMessage said;
      if (said.ParseFromArray(input.data, static_cast<int>(size))) peer.Say(said);
      input.data += size;
      input.size -= size;
      break;
    }
    case 4:
      peer.AddSegment(
          input.Take<std::uint8_t>() % 3,
          FalsePeer::Copy(shm::MakeSegment("hgros-fuzz", 8192, shm::Access::kOwnerOnly, shm::Pages::kAtOnce)));
      break;
    default:
      peer.slip().returned = input.Take<std::uint16_t>();
      peer.slip().slots[0] = input.Take<std::uint16_t>();
      peer.slip().cells[0].messages = input.Take<std::uint8_t>();
      peer.slip().cells[0].bytes = input.Take<std::uint16_t>();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Session session;
  Input input{data, size};
  FalsePeer peer(session.transport->place());
  const bool greets = input.Take<std::uint8_t>() % 8 != 0;
  if (greets && !peer.Publish(8, 4096)) std::abort();
  while (input.size > 0) Step(peer, input);
  peer.Ring();
  wire::PairMessage bye;
  bye.mutable_bye();
  peer.Say(bye);
  (void)peer.socket().Flush();
  peer.Hang();
  // For any input: the connection ends, and nothing of it is left.
  if (!hgros::test::Await([] { return session.transport->Peers().empty(); }, std::chrono::seconds(8))) std::abort();
  return 0;
}

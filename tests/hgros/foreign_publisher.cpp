// A session whose publisher describes its type in the way that its argument names, until it is killed, or its parent
// ends. It prints its endpoint.
//   large: with more bytes than are accepted
//   older: not at all, and the session takes requests of control only up to version 1
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <string_view>

#include <hgros/Snapshot.pb.h>

#include "hgros/session/snapshot_message.hpp"
#include "session/hand_made_session.hpp"

namespace hgros::cli {
namespace {

class ForeignPublisher final : public test::HandMadeSession, private OutboundSource {
 public:
  explicit ForeignPublisher(bool large) : HandMadeSession("foreign") {
    ZmqOptions options;
    options.publish = {{"tcp://127.0.0.1:*", std::nullopt}};
    OpenZmq(std::move(options));
    for (TypeInfo* type : {&hand_, &snapshot_}) type->encoding = Encoding::kProtobuf;
    hand_.name = "robot.Hand";
    hand_.fingerprint = 1;
    if (large) hand_.descriptor_set = [] { return std::string(3'000'000, 'x'); };
    snapshot_.name = "hgros.Snapshot";
    hands_ = zmq_->Advertise("hand", hand_, source_);
    if (!large) snapshots_ = zmq_->Advertise(kSnapshotsChannel, snapshot_, *this);
  }
  ~ForeignPublisher() {
    hands_.reset();
    snapshots_.reset();
  }
  [[nodiscard]] std::string endpoint() const { return zmq_->BoundEndpoints().front(); }

 private:
  class Hands : public OutboundSource {
    std::vector<OutboundMessage> Latched(SessionId /*subscriber*/) noexcept override { return {}; }
    void OnRoom() noexcept override {}
    void OnSubscribers(std::size_t /*count*/) noexcept override {}
  };
  // Each subscriber gets a snapshot.
  std::vector<OutboundMessage> Latched(SessionId /*subscriber*/) noexcept override {
    Snapshot snapshot;
    snapshot.set_control(1);
    PacketHead head;
    head.channel = kSnapshotsChannel;
    head.type_name = snapshot_.name;
    head.encoding = snapshot_.encoding;
    head.id = {id().value, 1, 1};
    head.latched = 1;
    const auto bytes = std::make_shared<const std::string>(snapshot.SerializeAsString());
    return {{head, {AsBytes(*bytes), bytes}}};
  }
  void OnRoom() noexcept override {}
  void OnSubscribers(std::size_t /*count*/) noexcept override {}

  TypeInfo hand_;
  TypeInfo snapshot_;
  Hands source_;
  std::unique_ptr<OutboundChannel> hands_;
  std::unique_ptr<OutboundChannel> snapshots_;
};

}  // namespace
}  // namespace hgros::cli

int main(int count, char** words) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const hgros::cli::ForeignPublisher publisher(count > 1 && std::string_view(words[1]) == "large");
  std::printf("%s\n", publisher.endpoint().c_str());
  std::fflush(stdout);
  for (;;) pause();
}

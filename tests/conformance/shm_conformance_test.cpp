// Runs the conformance suite over shared memory.
#include "conformance/transport_conformance.hpp"
#include "hgros/transport/shm_transport.hpp"

namespace hgros::conformance {
namespace {

class ShmWorld : public World {
 public:
  ShmWorld(ShmWait wait, std::uint64_t limit_bytes) : wait_(wait), limit_bytes_(limit_bytes) {}

  std::unique_ptr<Transport> MakePublisher(TransportListener& listener, Log& log, SessionId id) override {
    return Make(place_, {}, listener, log, id);
  }
  std::unique_ptr<Transport> MakeSubscriber(TransportListener& listener, Log& log, SessionId id) override {
    return Make({}, {place_}, listener, log, id);
  }
  bool shows_in_place() const override { return false; }

 private:
  std::unique_ptr<Transport> Make(const std::string& place, const std::vector<std::string>& peers,
                                  TransportListener& listener, Log& log, SessionId id) const {
    ShmOptions options;
    options.session = id;
    options.process = "conformance";
    options.place = place;
    options.peers = peers;
    options.wait = wait_;
    options.spin = std::chrono::microseconds(20);
    options.limit_bytes = limit_bytes_;
    options.heartbeat = std::chrono::milliseconds(100);
    options.peer_timeout = std::chrono::milliseconds(8000);
    return MakeShmTransport(std::move(options), listener, log);
  }

  const std::string place_ = "hgros-test-" + SessionId::Random().ToString();
  const ShmWait wait_;
  const std::uint64_t limit_bytes_;
};

std::function<std::unique_ptr<World>()> Make(ShmWait wait, std::uint64_t limit_bytes = 64 << 20) {
  return [=] { return std::make_unique<ShmWorld>(wait, limit_bytes); };
}

INSTANTIATE_TEST_SUITE_P(Shm, TransportConformance,
                         testing::Values(TransportCase{"Sleep", Make(ShmWait::kSleep)},
                                         TransportCase{"Spin", Make(ShmWait::kSpin)},
                                         TransportCase{"NoMemory", Make(ShmWait::kSleep, 0)}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace hgros::conformance

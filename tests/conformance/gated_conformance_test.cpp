// Runs the conformance suite over the transport that exists only in tests.
#include "conformance/transport_conformance.hpp"
#include "support/gated_transport.hpp"

namespace hgros::conformance {
namespace {

class GatedWorld : public World {
 public:
  std::unique_ptr<Transport> MakePublisher(TransportListener& listener, Log& log, SessionId id) override {
    return Make(place_, listener, log, id);
  }
  std::unique_ptr<Transport> MakeSubscriber(TransportListener& listener, Log& log, SessionId id) override {
    auto transport = Make({}, listener, log, id);
    transport->AddPeer(place_);
    return transport;
  }
  bool shows_in_place() const override { return false; }

 private:
  std::unique_ptr<Transport> Make(const std::string& place, TransportListener& listener, Log& log, SessionId id) {
    ShmOptions options = test::GatedOptions(id, place);
    options.peer_timeout = std::chrono::milliseconds(8000);
    return std::make_unique<test::GatedTransport>(std::move(options), listener, log, gate_);
  }

  const std::string place_ = "hgros-test-" + SessionId::Random().ToString();
  test::Gate gate_{true};
};

INSTANTIATE_TEST_SUITE_P(Gated, TransportConformance,
                         testing::Values(TransportCase{"Open", [] { return std::make_unique<GatedWorld>(); }}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace hgros::conformance

// Runs the conformance suite over ZeroMQ.
#include "conformance/tcp_forwarder.hpp"
#include "conformance/transport_conformance.hpp"
#include "hgros/transport/zmq_transport.hpp"
#include "support/free_port.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::conformance::zmq_conformance_test {
namespace {

class ZmqWorld : public World {
 public:
  std::unique_ptr<Transport> MakePublisher(TransportListener& listener, Log& log, SessionId id) override {
    ZmqOptions options;
    options.publish = {{publish_at_, std::nullopt}};
    return Make(std::move(options), listener, log, id);
  }
  std::unique_ptr<Transport> MakeSubscriber(TransportListener& listener, Log& log, SessionId id) override {
    ZmqOptions options;
    options.subscribe = {{subscribe_at_, std::nullopt, {}}};
    return Make(std::move(options), listener, log, id);
  }

 protected:
  std::string publish_at_;
  std::string subscribe_at_;

 private:
  static std::unique_ptr<Transport> Make(ZmqOptions options, TransportListener& listener, Log& log, SessionId id) {
    options.session = id;
    options.process = "conformance";
    options.heartbeat = std::chrono::milliseconds(100);
    options.peer_timeout = std::chrono::milliseconds(8000);
    return MakeZmqTransport(std::move(options), listener, log);
  }
};

class IpcWorld : public ZmqWorld {
 public:
  IpcWorld() { publish_at_ = subscribe_at_ = folder_.Ipc(); }

 private:
  const test::ScratchFolder folder_;
};

class TcpWorld : public ZmqWorld {
 public:
  TcpWorld() {
    const std::uint16_t port = test::FreePort();
    publish_at_ = "tcp://127.0.0.1:" + std::to_string(port);
    forwarder_ = std::make_unique<TcpForwarder>(port);
    subscribe_at_ = "tcp://127.0.0.1:" + std::to_string(forwarder_->port());
  }
  Cable* cable() override { return forwarder_.get(); }

 private:
  std::unique_ptr<TcpForwarder> forwarder_;
};

INSTANTIATE_TEST_SUITE_P(Zmq, TransportConformance,
                         testing::Values(TransportCase{"Ipc", [] { return std::make_unique<IpcWorld>(); }},
                                         TransportCase{"Tcp", [] { return std::make_unique<TcpWorld>(); }}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace hgros::conformance::zmq_conformance_test

// Runs the conformance suite over ZeroMQ.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "conformance/tcp_forwarder.hpp"
#include "conformance/transport_conformance.hpp"
#include "hgros/transport/zmq_transport.hpp"
#include "support/free_port.hpp"

namespace hgros::conformance::zmq_conformance_test {
namespace {

ZmqOptions Options(SessionId id) {
  ZmqOptions options;
  options.session = id;
  options.process = "conformance";
  options.heartbeat = std::chrono::milliseconds(100);
  options.peer_timeout = std::chrono::milliseconds(8000);
  return options;
}

class ZmqWorld : public World {
 public:
  std::unique_ptr<Transport> MakePublisher(TransportListener& listener, Log& log, SessionId id) override {
    ZmqOptions options = Options(id);
    options.publish = {{publish_at_, std::nullopt}};
    return MakeZmqTransport(std::move(options), listener, log);
  }
  std::unique_ptr<Transport> MakeSubscriber(TransportListener& listener, Log& log, SessionId id) override {
    ZmqOptions options = Options(id);
    options.subscribe = {{subscribe_at_, std::nullopt, {}}};
    return MakeZmqTransport(std::move(options), listener, log);
  }

 protected:
  std::string publish_at_;
  std::string subscribe_at_;
};

class IpcWorld : public ZmqWorld {
 public:
  IpcWorld() {
    std::string folder = std::filesystem::temp_directory_path() / "hgros-XXXXXX";
    folder_ = mkdtemp(folder.data());
    publish_at_ = subscribe_at_ = "ipc://" + folder_ + "/socket";
  }
  ~IpcWorld() override { std::filesystem::remove_all(folder_); }

 private:
  std::string folder_;
};

class TcpWorld : public ZmqWorld {
 public:
  TcpWorld() : ZmqWorld() {
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

// Ours, called as a program calls it: a session with one endpoint, ToAny and FromAny.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include <foxglove/PointCloud.pb.h>

#include "hgros/hgros.hpp"
#include "support/pair.hpp"

namespace hgros::bench {
namespace {

constexpr const char* kChannel = "blocks";
constexpr const char* kPlainChannel = "clouds";
constexpr std::size_t kLosslessDepth = 1000;

void Quiet(LogLevel level, std::string_view text) {
  if (level >= LogLevel::kWarning) std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
}

// A session that either discovers the other one or knows only its endpoint.
Config ConfigFor(const std::string& endpoint, std::vector<EndpointConfig> Config::*side) {
  constexpr std::string_view kDomain = "domain:";
  Config config;
  if (endpoint.starts_with(kDomain)) {
    unsetenv("HGROS_DOMAIN");
    config.discovery.domain = endpoint.substr(kDomain.size());
  } else {
    config.discovery.local = false;
    (config.*side).push_back({endpoint, {}, true});
  }
  return config;
}

class OurSender final : public PairSender {
 public:
  explicit OurSender(const std::string& endpoint)
      : session_(ConfigFor(endpoint, &Config::publishers), {"bench_pub", Quiet}),
        publish_(session_.Advertise<Block>(kChannel)) {
    if (!session_.WaitForSubscribers(kChannel, 1, std::chrono::seconds(20))) {
      std::fprintf(stderr, "our receiver did not start within 20 s\n");
      std::exit(2);
    }
  }
  void Send(const std::shared_ptr<Block>& block) override {
    const PublishStatus status =
        publish_.Wait(std::shared_ptr<const Block>(block), std::chrono::steady_clock::now() + std::chrono::seconds(5));
    if (status != PublishStatus::kOk) {
      std::fprintf(stderr, "publishing failed with \"%s\"\n", std::string(ToString(status)).c_str());
    }
  }

 private:
  Session session_;
  Publisher<Block> publish_;
};

// The same bytes inside an ordinary protobuf message.
class OurPlainSender final : public PairSender {
 public:
  explicit OurPlainSender(const std::string& endpoint)
      : session_(ConfigFor(endpoint, &Config::publishers), {"bench_pub", Quiet}),
        publish_(session_.Advertise<foxglove::PointCloud>(kPlainChannel)) {
    if (!session_.WaitForSubscribers(kPlainChannel, 1, std::chrono::seconds(20))) {
      std::fprintf(stderr, "our receiver did not start within 20 s\n");
      std::exit(2);
    }
  }
  void Send(const std::shared_ptr<Block>& block) override {
    // One message for each block, created and filled before the measurement. Messages, too, do not change in flight.
    std::shared_ptr<foxglove::PointCloud>& cloud = clouds_[block.get()];
    if (!cloud || cloud->data().size() != block->size()) {  // A block of another pool may have had this address.
      cloud = std::make_shared<foxglove::PointCloud>();
      cloud->set_frame_id("lidar");
      cloud->set_point_stride(16);
      cloud->set_data(block->bytes().data(), block->size());
    }
    std::memcpy(cloud->mutable_data()->data(), block->bytes().data(), sizeof(Stamp));
    publish_(std::shared_ptr<const foxglove::PointCloud>(cloud));
  }

 private:
  Session session_;
  Publisher<foxglove::PointCloud> publish_;
  std::map<const Block*, std::shared_ptr<foxglove::PointCloud>> clouds_;
};

class OurPlainReceiver final : public PairReceiver {
 public:
  OurPlainReceiver(const std::string& endpoint, PairControl& control)
      : session_(ConfigFor(endpoint, &Config::subscribers), {"bench_sub", Quiet}),
        subscription_(session_.FromAny<foxglove::PointCloud>(
            kPlainChannel, Invoke::kSerial,
            [&control](const foxglove::PointCloud& cloud) { NoteArrival(control, AsBytes(cloud.data())); },
            {{}, {}, Executor::Inline()})) {}

 private:
  Session session_;
  Subscription subscription_;
};

using BulkCloud = Bulk<foxglove::PointCloud>;

// A point cloud that is lent for each message. Its bytes are those of an earlier one except for the stamp: as with the
// other ways, filling is not measured.
class OurBulkSender final : public PairSender {
 public:
  explicit OurBulkSender(const std::string& endpoint)
      : session_(ConfigFor(endpoint, &Config::publishers), {"bench_pub", Quiet}),
        publish_(session_.Advertise<BulkCloud>(kPlainChannel)) {
    if (!session_.WaitForSubscribers(kPlainChannel, 1, std::chrono::seconds(20))) {
      std::fprintf(stderr, "our receiver did not start within 20 s\n");
      std::exit(2);
    }
  }
  void Send(const std::shared_ptr<Block>& block) override {
    auto cloud = session_.Loan<BulkCloud>(kPlainChannel, block->size());
    cloud->head().set_frame_id("lidar");
    cloud->head().set_point_stride(16);
    std::memcpy(cloud->writable().data(), block->bytes().data(), sizeof(Stamp));
    publish_(std::move(cloud));
  }

 private:
  Session session_;
  Publisher<BulkCloud> publish_;
};

class OurBulkReceiver final : public PairReceiver {
 public:
  OurBulkReceiver(const std::string& endpoint, PairControl& control)
      : session_(ConfigFor(endpoint, &Config::subscribers), {"bench_sub", Quiet}),
        subscription_(session_.FromAny<BulkCloud>(
            kPlainChannel, Invoke::kSerial, [&control](const BulkCloud& cloud) { NoteArrival(control, cloud.bytes()); },
            {{}, {}, Executor::Inline()})) {}

 private:
  Session session_;
  Subscription subscription_;
};

class OurReceiver final : public PairReceiver {
 public:
  OurReceiver(const std::string& endpoint, PairControl& control, const std::string& executor, bool lossless)
      : session_(ConfigFor(endpoint, &Config::subscribers), {"bench_sub", Quiet}),
        subscription_(session_.FromAny<Block>(
            kChannel, Invoke::kSerial, [&control](const Block& block) { NoteArrival(control, block.bytes()); },
            {{},
             lossless ? Queue::KeepAll(kLosslessDepth) : Queue::KeepLast(Queue::kDefaultDepth),
             executor == "tbb" ? Executor::Tbb() : Executor::Inline()})) {}

 private:
  Session session_;
  Subscription subscription_;
};

}  // namespace

std::unique_ptr<PairSender> MakeOurSender(const std::string& endpoint, bool) {
  return std::make_unique<OurSender>(endpoint);
}
std::unique_ptr<PairSender> MakeOurPlainSender(const std::string& endpoint) {
  return std::make_unique<OurPlainSender>(endpoint);
}
std::unique_ptr<PairReceiver> MakeOurPlainReceiver(const std::string& endpoint, PairControl& control) {
  return std::make_unique<OurPlainReceiver>(endpoint, control);
}
std::unique_ptr<PairSender> MakeOurBulkSender(const std::string& endpoint) {
  return std::make_unique<OurBulkSender>(endpoint);
}
std::unique_ptr<PairReceiver> MakeOurBulkReceiver(const std::string& endpoint, PairControl& control) {
  return std::make_unique<OurBulkReceiver>(endpoint, control);
}
std::unique_ptr<PairReceiver> MakeOurReceiver(const std::string& endpoint, PairControl& control,
                                              const std::string& executor, bool lossless) {
  return std::make_unique<OurReceiver>(endpoint, control, executor, lossless);
}

}  // namespace hgros::bench

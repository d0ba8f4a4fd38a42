// Ours, called as a program calls it: a session with one endpoint, ToAny and FromAny.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "hgros/hgros.hpp"
#include "support/pair.hpp"

namespace hgros::bench {
namespace {

constexpr const char* kChannel = "blocks";
constexpr std::size_t kLosslessDepth = 1000;

void Quiet(LogLevel level, std::string_view text) {
  if (level >= LogLevel::kWarning) std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
}

// A session that either finds the other one by itself or knows nothing but its endpoint.
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
      std::fprintf(stderr, "our receiver did not come within 20 s\n");
      std::exit(2);
    }
  }
  void Send(const std::shared_ptr<Block>& block) override {
    const PublishStatus status =
        publish_.Wait(std::shared_ptr<const Block>(block), std::chrono::steady_clock::now() + std::chrono::seconds(5));
    if (status != PublishStatus::kOk) {
      std::fprintf(stderr, "a publish ended with \"%s\"\n", std::string(ToString(status)).c_str());
    }
  }

 private:
  Session session_;
  Publisher<Block> publish_;
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
std::unique_ptr<PairReceiver> MakeOurReceiver(const std::string& endpoint, PairControl& control,
                                              const std::string& executor, bool lossless) {
  return std::make_unique<OurReceiver>(endpoint, control, executor, lossless);
}

}  // namespace hgros::bench

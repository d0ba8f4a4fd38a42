// A link of a chain: hears one channel, and speaks on the next.
#include <foxglove/KeyValuePair.pb.h>
#include <hgros/component/component.hpp>

namespace {

class Link {
 public:
  explicit Link(hgros::Context& context)
      : log_(context.log()), next_(context.Advertise<foxglove::KeyValuePair>("next")) {
    context.FromAny<foxglove::KeyValuePair>(
        "last", hgros::Invoke::kSerial,
        [this](const std::shared_ptr<const foxglove::KeyValuePair>& message) { (void)next_(message); });
  }
  void Activate() { log_.Write(hgros::LogLevel::kInfo, "runs"); }

 private:
  hgros::Log& log_;
  hgros::Publisher<foxglove::KeyValuePair> next_;
};
HGROS_COMPONENT(Link, "bench/Link")

}  // namespace

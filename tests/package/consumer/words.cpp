#include <foxglove/KeyValuePair.pb.h>
#include <hgros/component/component.hpp>

struct Counter {
  explicit Counter(hgros::Context& context) {
    context.FromAny<foxglove::KeyValuePair>("word", hgros::Invoke::kSerial, [](const foxglove::KeyValuePair&) {});
  }
};
HGROS_COMPONENT(Counter, "words/Counter")

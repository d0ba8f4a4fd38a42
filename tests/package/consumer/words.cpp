#include <word.pb.h>

#include <hgros/component/component.hpp>

struct Counter {
  explicit Counter(hgros::Context& context) {
    context.FromAny<words::Word>("word", hgros::Invoke::kSerial, [](const words::Word&) {});
  }
};
HGROS_COMPONENT(Counter, "words/Counter")

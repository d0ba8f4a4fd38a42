#include <chrono>

#include <foxglove/KeyValuePair.pb.h>
#include <hgros/component/component.hpp>

namespace {

using foxglove::KeyValuePair;

class Counter {
 public:
  explicit Counter(hgros::Context& context)
      : step_(context.Declare("step", 1,
                              {.description = "Added by each word.", .unit = "words", .least = 1, .most = 10})),
        counts_(context.Advertise<KeyValuePair>("count")) {
    context.FromAny<KeyValuePair>("word", hgros::Invoke::kSerial, [this](const KeyValuePair&) {
      count_ += step_;
      counts_(Save());
    });
    context.Serve<KeyValuePair, KeyValuePair>("reset", [](const KeyValuePair& request) { return request; });
    context.CreateTimer("report", std::chrono::milliseconds(250), [](const hgros::Tick&) {});
  }
  [[nodiscard]] KeyValuePair Save() const {
    KeyValuePair state;
    state.set_value(std::to_string(count_));
    return state;
  }
  void Restore(const KeyValuePair& state) { count_ = std::stoi(state.value()); }

 private:
  const int step_;
  int count_ = 0;
  hgros::Publisher<KeyValuePair> counts_;
};
HGROS_COMPONENT(Counter, "words/Counter")

class Source {
 public:
  explicit Source(hgros::Context& context) : words_(context.Advertise<KeyValuePair>("word")) {}

 private:
  hgros::Publisher<KeyValuePair> words_;
};
HGROS_COMPONENT(Source, "words/Source")

}  // namespace

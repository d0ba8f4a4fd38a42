// A component that moves, between one that publishes and one that measures what comes.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <foxglove/KeyValuePair.pb.h>
#include <hgros/component/component.hpp>

namespace {

using foxglove::KeyValuePair;
using Clock = std::chrono::steady_clock;

// A message every millisecond.
class Beats {
 public:
  explicit Beats(hgros::Context& context) : beats_(context.Advertise<KeyValuePair>("beat")) {}
  void Activate() {
    thread_ = std::jthread([this](const std::stop_token& stop) { Publish(stop); });
  }
  void Deactivate() { thread_ = {}; }

 private:
  void Publish(const std::stop_token& stop) {
    auto next = Clock::now();
    for (int number = 1; !stop.stop_requested(); ++number) {
      auto message = std::make_unique<KeyValuePair>();
      message->set_value(std::to_string(number));
      (void)beats_.Wait(std::move(message), Clock::now() + std::chrono::seconds(10), stop);
      next += std::chrono::milliseconds(1);
      std::this_thread::sleep_until(next);
    }
  }
  hgros::Publisher<KeyValuePair> beats_;
  std::jthread thread_;
};
HGROS_COMPONENT(Beats, "bench/Beats")

// Passes them on, with a state of 1 MB.
class Carrier {
 public:
  explicit Carrier(hgros::Context& context) : passed_(context.Advertise<KeyValuePair>("passed")) {
    context.FromAny<KeyValuePair>(
        "beat", hgros::Invoke::kSerial,
        [this](const std::shared_ptr<const KeyValuePair>& message) { (void)passed_(message); },
        {.name = {}, .queue = hgros::Queue::KeepAll(10'000), .executor = {}});
  }
  [[nodiscard]] KeyValuePair Save() const {
    KeyValuePair state;
    state.set_value(std::string(1'000'000, 's'));
    return state;
  }
  void Restore(const KeyValuePair&) {}

 private:
  hgros::Publisher<KeyValuePair> passed_;
};
HGROS_COMPONENT(Carrier, "bench/Carrier")

// Says after every 100 messages how long none came at most, and whether one was missing.
class Gaps {
 public:
  explicit Gaps(hgros::Context& context) : log_(context.log()) {
    context.FromAny<KeyValuePair>("passed", hgros::Invoke::kSerial,
                                  [this](const KeyValuePair& message) { Take(std::stoi(message.value())); },
                                  {.name = {}, .queue = hgros::Queue::KeepAll(10'000), .executor = {}});
  }

 private:
  void Take(int number) {
    const auto now = Clock::now();
    if (last_ != 0 && number != last_ + 1) log_.Write(hgros::LogLevel::kError, "lost or doubled");
    if (last_ != 0) longest_ = std::max(longest_, now - came_);
    last_ = number;
    came_ = now;
    if (number % 100 != 0) return;
    log_.Write(hgros::LogLevel::kInfo,
               "gap " + std::to_string(std::chrono::duration<double, std::milli>(longest_).count()));
    longest_ = {};
  }
  hgros::Log& log_;
  int last_ = 0;
  Clock::time_point came_{};
  Clock::duration longest_{};
};
HGROS_COMPONENT(Gaps, "bench/Gaps")

}  // namespace

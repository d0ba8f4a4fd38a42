// Components of the robots in move_test.cpp and bench/placement.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>

#include <foxglove/KeyValuePair.pb.h>
#include <hgros/component/component.hpp>

namespace {

using foxglove::KeyValuePair;

KeyValuePair Message(long long number) {
  KeyValuePair message;
  message.set_value(std::to_string(number));
  return message;
}

// Publishes the numbers from 1 while it is active, every one to a subscriber that has room.
class Counting {
 public:
  explicit Counting(hgros::Context& context)
      : pause_(std::chrono::microseconds(context.Declare("pause_us", 500, {.least = 0}))),
        numbers_(context.Advertise<KeyValuePair>("number")) {}
  void Activate() {
    thread_ = std::jthread([this](const std::stop_token& stop) { Publish(stop); });
  }
  void Deactivate() { thread_ = {}; }

 private:
  void Publish(const std::stop_token& stop) {
    auto next = std::chrono::steady_clock::now();
    for (int number = 1; !stop.stop_requested(); ++number) {
      (void)numbers_.Wait(std::make_unique<KeyValuePair>(Message(number)),
                          std::chrono::steady_clock::now() + std::chrono::seconds(10), stop);
      next += pause_;
      std::unique_lock lock(mutex_);
      (void)never_.wait_until(lock, stop, next, [] { return false; });
    }
  }
  const std::chrono::microseconds pause_;
  std::mutex mutex_;
  std::condition_variable_any never_;
  hgros::Publisher<KeyValuePair> numbers_;
  std::jthread thread_;
};
HGROS_COMPONENT(Counting, "moving/Counting")

// Publishes what it gets, and knows how many that were. Its state has at least `bytes` bytes.
class Passing {
 public:
  explicit Passing(hgros::Context& context)
      : context_(context),
        bytes_(static_cast<std::size_t>(context.Declare("bytes", 0, {.least = 0}))),
        tells_(context.Declare("tells", false)),
        passed_(context.Advertise<KeyValuePair>("passed")) {
    (void)context.Declare("activate", true);
    context.FromAny<KeyValuePair>("number", hgros::Invoke::kSerial,
                                  [this](const KeyValuePair& message) {
                                    if (tells_ && passes_++ == 0) {
                                      context_.log().Write(hgros::LogLevel::kInfo, "passes from " + message.value());
                                    }
                                    ++count_;
                                    (void)passed_.Wait(std::make_unique<KeyValuePair>(message),
                                                       std::chrono::steady_clock::now() + std::chrono::seconds(10));
                                  },
                                  {.name = {}, .queue = hgros::Queue::KeepAll(10'000), .executor = {}});
    context.Serve<KeyValuePair, KeyValuePair>("count", [this](const KeyValuePair&) { return Message(count_); });
  }
  void Activate() {
    if (begun_ && !context_.params().Get<bool>("activate")) throw std::runtime_error("it does not want to be here");
  }
  [[nodiscard]] KeyValuePair Save() const {
    KeyValuePair state = Message(count_);
    state.set_key(std::string(bytes_, 's'));
    return state;
  }
  void Restore(const KeyValuePair& state) {
    count_ = std::stoll(state.value());
    begun_ = true;
  }

 private:
  hgros::Context& context_;
  const std::size_t bytes_;
  const bool tells_;  // With which message it begins.
  hgros::Publisher<KeyValuePair> passed_;
  long long passes_ = 0;
  long long count_ = 0;
  bool begun_ = false;
};
HGROS_COMPONENT(Passing, "moving/Passing")

// Says which numbers do not come one after the other, and when it is asked how many came.
class Judging {
 public:
  explicit Judging(hgros::Context& context) : log_(context.log()) {
    context.FromAny<KeyValuePair>("passed", hgros::Invoke::kSerial,
                                  [this](const KeyValuePair& message) { Take(std::stoi(message.value())); },
                                  {.name = {}, .queue = hgros::Queue::KeepAll(10'000), .executor = {}});
    context.FromAny<KeyValuePair>("ask", hgros::Invoke::kSerial, [this](const KeyValuePair& question) {
      log_.Write(hgros::LogLevel::kInfo, "answers " + question.value() + ": up to " + std::to_string(last_) + ".");
    });
  }

 private:
  void Take(int number) {
    if (number <= last_) {
      log_.Write(hgros::LogLevel::kWarning, "again " + std::to_string(number) + " after " + std::to_string(last_));
      return;
    }
    if (number > last_ + 1) {
      log_.Write(hgros::LogLevel::kWarning, "lost " + std::to_string(last_ + 1) + " to " + std::to_string(number - 1));
    }
    last_ = number;
    if (number % 1000 == 0) log_.Write(hgros::LogLevel::kInfo, "has " + std::to_string(number) + ".");
  }
  hgros::Log& log_;
  std::atomic<int> last_ = 0;
};
HGROS_COMPONENT(Judging, "moving/Judging")

// Its state is the last number.
class Numbered {
 public:
  [[nodiscard]] KeyValuePair Save() const { return Message(last_); }
  void Restore(const KeyValuePair& state) { last_ = std::stoi(state.value()); }

 protected:
  int last_ = 0;
};

// Publishes the numbers from 1 every 10 ms while there is room.
class Source : public Numbered {
 public:
  explicit Source(hgros::Context& context) : numbers_(context.Advertise<KeyValuePair>("number")) {
    context.CreateTimer("next", std::chrono::milliseconds(10), [this](const hgros::Tick&) {
      if (numbers_(std::make_unique<KeyValuePair>(Message(last_ + 1))) == hgros::PublishStatus::kOk) ++last_;
    });
  }

 private:
  hgros::Publisher<KeyValuePair> numbers_;
};
HGROS_COMPONENT(Source, "moving/Source")

// Takes longer for a number than Source, and says which do not come one after the other.
class Slow : public Numbered {
 public:
  explicit Slow(hgros::Context& context) : log_(context.log()) {
    context.FromAny<KeyValuePair>("number", hgros::Invoke::kSerial,
                                  [this](const KeyValuePair& message) { Take(std::stoi(message.value())); },
                                  {.name = {}, .queue = hgros::Queue::KeepAll(50), .executor = {}});
  }

 private:
  void Take(int number) {
    if (number != last_ + 1) {
      log_.Write(hgros::LogLevel::kWarning, "got " + std::to_string(number) + " after " + std::to_string(last_));
    }
    last_ = number;
    std::unique_lock lock(mutex_);
    (void)never_.wait_for(lock, std::chrono::milliseconds(30), [] { return false; });
    if (number % 50 == 0) log_.Write(hgros::LogLevel::kInfo, "has " + std::to_string(number) + ".");
  }
  hgros::Log& log_;
  std::mutex mutex_;
  std::condition_variable never_;
};
HGROS_COMPONENT(Slow, "moving/Slow")

}  // namespace

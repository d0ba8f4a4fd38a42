// Components of the robots in run_test.cpp.
#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

#include <foxglove/KeyValuePair.pb.h>
#include <foxglove/PoseInFrame.pb.h>
#include <hgros/component/component.hpp>
#include <hgros/tf/transforms.hpp>

namespace {

using foxglove::KeyValuePair;

void Wait(std::chrono::milliseconds time) {
  std::mutex mutex;
  std::condition_variable never;
  std::unique_lock lock(mutex);
  (void)never.wait_for(lock, time, [] { return false; });
}

std::unique_ptr<KeyValuePair> Numbered(int number) {
  auto message = std::make_unique<KeyValuePair>();
  message->set_value(std::to_string(number));
  return message;
}

// Publishes the numbers from 1 to `count` as soon as it runs: a subscriber that has not joined misses some.
class Numbers {
 public:
  explicit Numbers(hgros::Context& context)
      : context_(context),
        count_(context.Declare("count", 100, {.least = 0})),
        numbers_(context.Advertise<KeyValuePair>("number")) {}
  void Activate() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    for (int number = 1; number <= count_; ++number) (void)numbers_.Wait(Numbered(number), deadline);
    context_.Finish(std::to_string(count_) + " numbers");
  }

 private:
  hgros::Context& context_;
  const int count_;
  hgros::Publisher<KeyValuePair> numbers_;
};
HGROS_COMPONENT(Numbers, "relay/Numbers")

// Expects the numbers from 1 to `count`, without a gap.
class Checker {
 public:
  explicit Checker(hgros::Context& context) : count_(context.Declare("count", 100)) {
    context.FromAny<KeyValuePair>("number", hgros::Invoke::kSerial,
                                  [this, &context](const KeyValuePair& message) {
                                    if (std::stoi(message.value()) != ++last_)
                                      context.Fail("got " + message.value() + " as number " + std::to_string(last_));
                                    if (last_ == count_) context.Finish("all " + std::to_string(count_));
                                  },
                                  {.name = {}, .queue = hgros::Queue::KeepAll(1000), .executor = {}});
  }

 private:
  const int count_;
  int last_ = 0;
};
HGROS_COMPONENT(Checker, "relay/Checker")

// Does what its parameter says, soon after it runs.
class Does {
 public:
  explicit Does(hgros::Context& context) : context_(context), what_(context.Declare("what", "nothing")) {
    const bool again = std::exchange(constructed_before, true);
    if (what_ == "throw at start" || (what_ == "throw at restart" && again)) {
      throw std::runtime_error("there is no laser at /dev/ttyUSB0");
    }
    if (what_ == "throw late" && again) Wait(std::chrono::seconds(1));
    // A FIFO: waits until somebody opens it for writing.
    if (const char* door = std::getenv("RELAY_DOOR")) close(open(door, O_RDONLY | O_CLOEXEC));
    context.CreateTimer("soon", std::chrono::milliseconds(50), [this](const hgros::Tick&) { Do(); });
  }
  void Activate() {
    if (what_ == "hang at start") context_.log().Write(hgros::LogLevel::kInfo, "I hang.");
    while (what_ == "hang at start") (void)pause();
    if (what_ == "run late") Wait(std::chrono::milliseconds(700));
    context_.log().Write(hgros::LogLevel::kInfo, "I run.");
  }
  void Deactivate() {
    context_.log().Write(hgros::LogLevel::kInfo, "I end.");
    if (what_ == "finish once" && done_) Wait(std::chrono::seconds(1));
    while (what_ == "hang at end") (void)pause();
    if (what_ == "crash at end") std::abort();
  }

 private:
  void Do() {
    if (done_) return;
    if (what_ == "throw always") throw std::runtime_error("it is always too dark");
    done_ = true;
    if (what_ == "crash") std::abort();
    if (what_ == "hang") context_.log().Write(hgros::LogLevel::kInfo, "I hang.");
    while (what_ == "hang") (void)pause();
    if (what_ == "exit") std::exit(7);
    if (what_ == "exit well") _exit(0);
    if (what_ == "fail") context_.Fail("the laser is broken");
    if (what_ == "finish") context_.Finish("enough");
    if (what_ == "finish once" && IsFirst()) context_.Finish("enough");
    if (what_ == "fail, then finish") IsFirst() ? context_.Fail("the laser is cold") : context_.Finish("enough");
    if (what_ == "throw late") {
      context_.log().Write(hgros::LogLevel::kInfo, "I wait.");
      Wait(std::chrono::milliseconds(700));
    }
    if (what_ == "throw" || what_ == "throw late") throw std::runtime_error("it is too dark");
    if (what_ == "log") context_.log().Write(hgros::LogLevel::kWarning, "It is\n\x1b[31mdark.");
    if (what_ == "allocate") allocated_.resize(std::size_t{600} << 20U);
    if (what_ == "log much") context_.log().Write(hgros::LogLevel::kInfo, std::string(std::size_t{70} << 20U, 'x'));
    if (what_ == "log bytes") {
      context_.log().Write(hgros::LogLevel::kWarning, "\xfe\xff is no text");
      context_.log().Write(hgros::LogLevel::kInfo, "after it");
    }
    if (what_ == "print") std::printf("printed, and\nin two lines\n");
  }

  // False in the process that follows.
  bool IsFirst() {
    const std::filesystem::path before = std::filesystem::path(std::getenv("FOLDER")) / "has_ended";
    done_ = !std::filesystem::exists(before);
    if (done_) std::ofstream(before).flush();
    return done_;
  }

  static inline bool constructed_before = false;

  hgros::Context& context_;
  const std::string what_;
  bool done_ = false;
  std::string allocated_;
};
HGROS_COMPONENT(Does, "relay/Does")

// Counts the words that it hears in its state, and says what it holds; "echo" is not counted. When a state is saved
// again, it says that it was saved before: the starter hears what the component says after the state itself.
class Counter {
 public:
  explicit Counter(hgros::Context& context)
      : context_(context),
        step_(context.Declare("step", 1)),
        ballast_bytes_(context.Declare("ballast_bytes", 0)),
        hangs_at_end_(context.Declare("hangs_at_end", false)),
        counts_(context.Advertise<KeyValuePair>("count")) {
    context.FromAny<KeyValuePair>("word", hgros::Invoke::kSerial, [this](const KeyValuePair& word) {
      if (word.value() == "throw") throw std::runtime_error("it does not know this word");
      if (word.value() == "echo") return Say("holds");
      if (word.value() == "secret") secret_ = true;
      if (word.value() == "slow") Wait(std::chrono::milliseconds(500));
      while (word.value() == "hang") Wait(std::chrono::hours(1));
      count_ += static_cast<int>(context_.params().Get<int>("step"));
      Say("counts");
      (void)counts_(Numbered(count_));
    });
  }
  void Activate() { Say("begins at"); }
  void Deactivate() {
    while (hangs_at_end_) Wait(std::chrono::hours(1));
  }
  [[nodiscard]] KeyValuePair Save() const {
    if (secret_) throw std::runtime_error("its state is secret");
    times_saved_ = count_ == saved_ ? times_saved_ + 1 : 1;
    saved_ = count_;
    if (times_saved_ == 2) Say("has saved");
    KeyValuePair state = *Numbered(count_);
    state.set_key(std::string(static_cast<std::size_t>(ballast_bytes_), 'x'));
    return state;
  }
  void Restore(const KeyValuePair& state) { count_ = std::stoi(state.value()); }

 private:
  void Say(const std::string& what) const {
    context_.log().Write(hgros::LogLevel::kInfo, what + " " + std::to_string(count_) + ".");
  }

  hgros::Context& context_;
  int step_;
  const int ballast_bytes_;
  const bool hangs_at_end_;
  hgros::Publisher<KeyValuePair> counts_;
  int count_ = 0;
  bool secret_ = false;
  mutable int saved_ = -1;
  mutable int times_saved_ = 0;
};
HGROS_COMPONENT(Counter, "relay/Counter")

// Expects another type on the channel of Numbers, and calls a service.
class Pose {
 public:
  explicit Pose(hgros::Context& context) : plans_(context.Client<KeyValuePair, KeyValuePair>("plan")) {
    context.FromAny<foxglove::PoseInFrame>("number", hgros::Invoke::kSerial, [](const foxglove::PoseInFrame&) {});
  }

 private:
  hgros::ServiceClient<KeyValuePair, KeyValuePair> plans_;
};
HGROS_COMPONENT(Pose, "relay/Pose")

// Sets edges of its own, and says when it can look up those of the other one.
class Frames {
 public:
  explicit Frames(hgros::Context& context) : context_(context) {
    const std::string own = context.Declare("sets", "");
    const std::string other = context.Declare("sees", "");
    if (context.Declare("declares", true)) (void)context.transforms();
    context.CreateTimer("look", std::chrono::milliseconds(20), [this, own, other](const hgros::Tick&) {
      hgros::Transforms& transforms = context_.transforms();
      (void)transforms.ToTF(hgros::WallNow(), "map", own, hgros::RigidTransform());
      (void)transforms.ToStaticTF(own, own + "_still", hgros::RigidTransform());
      if (transforms.FromTF(own + "_still", other + "_still") && !std::exchange(sees_, true)) {
        context_.log().Write(hgros::LogLevel::kInfo, "It sees " + other + ".");
      }
    });
  }

 private:
  hgros::Context& context_;
  bool sees_ = false;
};
HGROS_COMPONENT(Frames, "relay/Frames")

}  // namespace

#pragma once

#include <numeric>

#include <foxglove/PoseInFrame.pb.h>

#include "hgros/component/components.hpp"
#include "session/domain_fixture.hpp"

namespace hgros::test {

/// A session without others, its components, and what these said.
class Process {
 public:
  explicit Process(const std::string& yaml = {}, bool all_inline = true)
      : session(Config::Parse("discovery: {domain: none}\n" + yaml)),
        components(std::make_unique<Components>(session, Options(all_inline))) {}

  void Run() {
    components->Join();
    components->Start();
  }
  [[nodiscard]] ComponentStatus Status(const std::string& name) const {
    for (const ComponentStatus& one : components->statuses()) {
      if (one.name == name) return one;
    }
    return {};
  }
  [[nodiscard]] std::vector<std::string> lines() const {
    const std::scoped_lock lock(mutex_);
    return lines_;
  }
  [[nodiscard]] std::vector<ComponentState> states() const {
    const std::scoped_lock lock(mutex_);
    return states_;
  }

 private:
  ComponentsOptions Options(bool all_inline) {
    return {.log =
                [this](std::string_view component, LogLevel, std::string_view text) {
                  const std::scoped_lock lock(mutex_);
                  lines_.push_back(std::string(component) + "|" + std::string(text));
                },
            .on_change =
                [this](const ComponentStatus& status) {
                  const std::scoped_lock lock(mutex_);
                  states_.push_back(status.state);
                },
            .all_inline = all_inline};
  }
  mutable std::mutex mutex_;
  std::vector<std::string> lines_;
  std::vector<ComponentState> states_;

 public:
  Session session;
  std::unique_ptr<Components> components;
};

inline foxglove::PoseInFrame Numbered(std::int64_t number) {
  foxglove::PoseInFrame pose;
  pose.set_frame_id(std::to_string(number));
  return pose;
}

inline std::vector<int> UpTo(int last) {
  std::vector<int> numbers(static_cast<std::size_t>(last));
  std::iota(numbers.begin(), numbers.end(), 1);
  return numbers;
}

/// A session outside that publishes numbers, and sees those that components pass on.
class NumbersFixture : public DomainFixture {
 protected:
  static void Publish(const Publisher<foxglove::PoseInFrame>& to, int number) {
    while (to(Numbered(number)) == PublishStatus::kFull) Linger(std::chrono::milliseconds(1));
  }
  void Publish(int number) const { Publish(number_, number); }
  [[nodiscard]] std::vector<int> seen() const {
    const std::scoped_lock lock(mutex_);
    return seen_;
  }
  [[nodiscard]] std::size_t seen_count() const {
    const std::scoped_lock lock(mutex_);
    return seen_.size();
  }

  mutable std::mutex mutex_;
  std::vector<int> seen_;
  Session outside_{Config::Parse("discovery: {lan: false}"), {.name = "outside"}};
  const Publisher<foxglove::PoseInFrame> number_ = outside_.Advertise<foxglove::PoseInFrame>("number");
  const Subscription passed_ = outside_.FromAny<foxglove::PoseInFrame>("passed", Invoke::kSerial,
                                                                       [this](const foxglove::PoseInFrame& pose) {
                                                                         const std::scoped_lock lock(mutex_);
                                                                         seen_.push_back(std::stoi(pose.frame_id()));
                                                                       },
                                                                       {.queue = Queue::KeepAll(100'000)});
};

}  // namespace hgros::test

#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "hgros/component/components.hpp"
#include "hgros/session/session.hpp"

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

}  // namespace hgros::test

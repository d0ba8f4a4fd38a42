#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace hgros::cli {

/// What a service tells its service manager: the protocol of sd_notify(3), one datagram for each notice. Without
/// NOTIFY_SOCKET nobody is told.
///
/// Threading: one thread at a time. The constructor removes the variables from the environment, so that processes which
/// this one starts do not speak for it: call it before other threads exist.
class ServiceNotices {
 public:
  ServiceNotices();
  ServiceNotices(const ServiceNotices&) = delete;
  ServiceNotices& operator=(const ServiceNotices&) = delete;
  ~ServiceNotices();

  /// Whether somebody is told.
  [[nodiscard]] bool heard() const noexcept { return descriptor_ >= 0; }
  /// Such as "READY=1". A notice that the manager does not take at once is lost.
  void Tell(std::string_view notice) const noexcept;
  /// "STATUS=" with the text in one line.
  void TellStatus(std::string_view status) const;
  /// How often the manager must get "WATCHDOG=1" at least; 0: it does not watch.
  [[nodiscard]] std::chrono::microseconds watchdog() const noexcept { return watchdog_; }

 private:
  int descriptor_ = -1;
  std::string address_;
  std::chrono::microseconds watchdog_{0};
};

}  // namespace hgros::cli

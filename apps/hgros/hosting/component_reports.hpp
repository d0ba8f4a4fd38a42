#pragma once

#include <string_view>

#include "hgros/base/log.hpp"
#include "launch/run.pb.h"

namespace hgros::cli {

/// Takes reports about the components of a process: for its starter, or for the log of a service.
///
/// Thread safety: all functions.
class ComponentReports {
 public:
  ComponentReports() = default;
  ComponentReports(const ComponentReports&) = delete;
  ComponentReports& operator=(const ComponentReports&) = delete;
  virtual ~ComponentReports() = default;

  virtual void Tell(const RunReport& report) = 0;
  virtual void Line(std::string_view component, LogLevel level, std::string_view text) = 0;
  /// Lets the thread of HostedComponents call Work().
  virtual void Wake() noexcept = 0;
  /// Waits until all that was told has arrived, or nothing of it for a second.
  virtual void Flush() noexcept = 0;
  /// Whether reports are not taken fast enough.
  [[nodiscard]] virtual bool full() = 0;
};

}  // namespace hgros::cli

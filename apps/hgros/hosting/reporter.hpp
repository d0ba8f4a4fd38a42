#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

#include "hgros/base/log.hpp"
#include "hosting/component_reports.hpp"
#include "launch/run.pb.h"
#include "processes/message_stream.hpp"

namespace hgros::cli {

/// What the process tells its starter. A starter that does not read must not stop the robot: lines and states are then
/// lost, and lines are counted.
///
/// Thread safety: all functions but Read and Next, which belong to one thread.
class Reporter final : public ComponentReports {
 public:
  explicit Reporter(int socket);
  ~Reporter() override;

  void Tell(const RunReport& report) override;
  void Stage(RunReport::Stage stage);
  void Fault(const std::string& what);
  void Line(std::string_view component, LogLevel level, std::string_view text) override;

  [[nodiscard]] int socket() const noexcept { return stream_.descriptor(); }
  /// Readable after Wake(), and once something waits to be written.
  [[nodiscard]] int wakes() const noexcept { return wakes_; }
  void Wake() noexcept override;
  void Slept() noexcept;
  void Write();
  void Flush() noexcept override;
  /// Bytes that wait to be written.
  [[nodiscard]] std::size_t unsent();
  /// Whether so much waits to be written that no state is added.
  [[nodiscard]] bool full() override;

  /// Orders. The stream's two directions share nothing.
  [[nodiscard]] bool Read() { return stream_.Read(); }
  [[nodiscard]] bool Next(RunOrder& order) { return stream_.Next(order); }

 private:
  void NoteSent() noexcept;
  [[nodiscard]] bool TooManyLines() const;
  // As soon as there is room again.
  void TellLost();

  std::mutex mutex_;
  MessageStream stream_;
  const int wakes_;
  std::size_t unsent_line_bytes_ = 0;  // At most: since everything was sent.
  std::uint64_t lost_ = 0;
};

}  // namespace hgros::cli

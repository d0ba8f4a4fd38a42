#include "hosting/reporter.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <string>
#include <utility>

namespace hgros::cli {
namespace {

constexpr std::size_t kMostUnsentBytes = 1U << 20U;
constexpr std::size_t kMostReportedLineBytes = 64U << 10U;
constexpr std::chrono::seconds kFlushPatience{1};  // For the starter to read some of it.

}  // namespace

Reporter::Reporter(int socket) : stream_(socket), wakes_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
Reporter::~Reporter() { close(wakes_); }

void Reporter::Tell(const RunReport& report) {
  const std::scoped_lock lock(mutex_);
  NoteSent();
  if (report.has_line() && TooManyLines()) {
    ++lost_;
    return;
  }
  TellLost();
  stream_.Add(report);
  if (report.has_line()) unsent_line_bytes_ += report.ByteSizeLong();
  if (stream_.Write() && stream_.unsent() > 0) Wake();
}

void Reporter::Stage(RunReport::Stage stage) {
  RunReport report;
  report.set_stage(stage);
  Tell(report);
}

void Reporter::Fault(const std::string& what) {
  RunReport report;
  report.set_fault(what);
  Tell(report);
}

void Reporter::Line(std::string_view component, LogLevel level, std::string_view text) {
  RunReport report;
  RunReport::Line& line = *report.mutable_line();
  line.set_component(std::string(component));
  line.set_level(static_cast<int>(level));
  line.set_text(std::string(text.substr(0, kMostReportedLineBytes)));
  if (text.size() > kMostReportedLineBytes) {
    line.mutable_text()->append(" ... and " + std::to_string(text.size() - kMostReportedLineBytes) + " bytes more.");
  }
  line.set_time_ns(std::chrono::system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
  Tell(report);
}

void Reporter::Wake() noexcept {
  const std::uint64_t one = 1;
  (void)!write(wakes_, &one, sizeof one);
}

void Reporter::Slept() noexcept {
  std::uint64_t ignored = 0;
  (void)!read(wakes_, &ignored, sizeof ignored);
}

void Reporter::Write() {
  const std::scoped_lock lock(mutex_);
  (void)stream_.Write();
  NoteSent();
  TellLost();
}

void Reporter::Flush() noexcept {
  auto deadline = std::chrono::steady_clock::now() + kFlushPatience;
  for (std::size_t before = unsent(); before > 0;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    pollfd watched{socket(), POLLOUT, 0};
    if (left.count() <= 0 || (poll(&watched, 1, static_cast<int>(left.count())) < 0 && errno != EINTR)) return;
    if ((watched.revents & (POLLERR | POLLHUP)) != 0) return;  // The starter has gone.
    Write();
    const std::size_t now = unsent();
    if (now < before) deadline = std::chrono::steady_clock::now() + kFlushPatience;
    before = now;
  }
}

std::size_t Reporter::unsent() {
  const std::scoped_lock lock(mutex_);
  return stream_.unsent();
}

bool Reporter::full() {
  const std::scoped_lock lock(mutex_);
  return stream_.unsent() > kMostUnsentBytes;
}

void Reporter::NoteSent() noexcept {
  if (stream_.unsent() == 0) unsent_line_bytes_ = 0;
}

// States may be larger, and are on the way for a moment only.
bool Reporter::TooManyLines() const { return std::min(unsent_line_bytes_, stream_.unsent()) > kMostUnsentBytes; }

void Reporter::TellLost() {
  if (lost_ == 0 || TooManyLines()) return;
  RunReport lost;
  lost.set_lost(std::exchange(lost_, 0));
  stream_.Add(lost);
}

}  // namespace hgros::cli

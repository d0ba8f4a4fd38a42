#include "hgros/codec/protobuf_log.hpp"

#include <google/protobuf/stubs/logging.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>

namespace hgros {
namespace {

using google::protobuf::LogHandler;
using google::protobuf::LogLevel;

std::atomic<LogHandler*> before{nullptr};

void WriteSomeOf(LogLevel level, const char* file, int line, const std::string& text) {
  using Clock = std::chrono::steady_clock;
  static std::atomic<Clock::rep> next{0};
  constexpr auto kPause = std::chrono::duration_cast<Clock::duration>(std::chrono::seconds(10));
  if (text.find("invalid UTF-8") != std::string::npos) {
    const Clock::rep now = Clock::now().time_since_epoch().count();
    Clock::rep due = next.load();
    if (now < due || !next.compare_exchange_strong(due, now + kPause.count())) return;
  }
  if (LogHandler* const write = before.load()) write(level, file, line, text);
}

}  // namespace

void LimitProtobufLog() {
  LogHandler* const was = google::protobuf::SetLogHandler(WriteSomeOf);
  if (was != WriteSomeOf) before = was;
}

}  // namespace hgros

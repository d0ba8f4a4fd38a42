#include "robot/robot_options.hpp"

#include <algorithm>

#include "arguments/command.hpp"

namespace hgros::cli {

std::chrono::nanoseconds DurationOf(double seconds) {
  constexpr double kMostSeconds = 1e9;
  return std::chrono::nanoseconds(static_cast<std::int64_t>(std::min(seconds, kMostSeconds) * 1e9));
}

void RobotOptions::Declare(Arguments& arguments) {
  arguments.Flag("--json", style.json, "One JSON object per line");
  arguments.Flag("--exact", style.exact, "Numbers with all digits, without units");
  arguments.Option("--timeout", "SECONDS", timeout_s, "End with code 3 if this takes longer");
  arguments.Option("--domain", "NAME", domain,
                   "Meet the sessions of this domain; without it HGROS_DOMAIN or \"default\"");
  arguments.Option("--connect", "ENDPOINT", connect,
                   "Also meet the session at this endpoint, such as tcp://robot:5553");
  arguments.Option("--config", "FILE", config, "Take endpoints to connect to, keys and discovery from this YAML file",
                   ValueKind::kFile);
}

std::chrono::nanoseconds RobotOptions::Timeout(std::chrono::nanoseconds otherwise) const {
  if (!timeout_s) return otherwise;
  return std::max(DurationOf(*timeout_s) - (std::chrono::steady_clock::now() - begin), std::chrono::nanoseconds(0));
}

void RobotOptions::GiveUp(const std::string& what) const {
  if (timeout_s) throw TimedOut(what);
  throw Error(what);
}

std::string RobotOptions::SendingHint() const {
  if (connect.empty()) return {};
  return " Sessions behind --connect are heard, but they get messages only from endpoints that they connect to. Use "
         "discovery on both sides instead, such as lan in --config.";
}

}  // namespace hgros::cli

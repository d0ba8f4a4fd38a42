#include "doctor/finding.hpp"

#include "doctor/evidence.hpp"

namespace hgros::cli {

const char* NameOf(Severity severity) {
  return severity == Severity::kFault ? "fault" : severity == Severity::kWarning ? "warning" : "note";
}

std::string Evidence::NameOf(SessionId session) const {
  const auto name = names.find(session);
  return name == names.end() ? session.ToString() : name->second;
}

double Evidence::SecondsOf(SessionId session) const {
  const auto first = before.find(session);
  const auto second = after.find(session);
  if (first == before.end() || second == after.end()) return 0;
  const std::int64_t begin = first->second->steady_ns();
  const std::int64_t end = second->second->steady_ns();
  return begin < 0 || end <= begin ? 0 : static_cast<double>(end - begin) / 1e9;
}

}  // namespace hgros::cli

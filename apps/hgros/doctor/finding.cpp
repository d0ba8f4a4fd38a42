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

std::uint64_t Evidence::GrowthOf(SessionId session, const std::string& channel,
                                 std::uint64_t (Snapshot::Channel::*counter)() const) const {
  const Snapshot::Channel* last = CountersOf(after, session, channel);
  if (last == nullptr || !before.contains(session)) return 0;
  const Snapshot::Channel* first = CountersOf(before, session, channel);  // Null: it was not there yet.
  return Growth(first == nullptr ? 0 : (first->*counter)(), (last->*counter)());
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

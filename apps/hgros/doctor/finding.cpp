#include "doctor/finding.hpp"

#include "doctor/evidence.hpp"

namespace hgros::cli {

const char* NameOf(Severity severity) {
  return severity == Severity::kFault ? "fault" : severity == Severity::kWarning ? "warning" : "note";
}

std::string Evidence::NameOf(SessionId session) const {
  for (const KnownChannel& channel : channels) {
    for (const auto* users : {&channel.publishers, &channel.subscribers}) {
      for (const ChannelUser& user : *users) {
        if (user.session == session) return ShortName(user, false);
      }
    }
  }
  return session.ToString();
}

}  // namespace hgros::cli

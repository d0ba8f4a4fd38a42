// The part of ServiceCaller that tells people what is wrong with the servers.
#include <algorithm>
#include <utility>

#include "hgros/base/names.hpp"
#include "hgros/services/services.hpp"
#include "services/service_caller.hpp"

namespace hgros {
namespace {

// Many calls may fail at a time, and looking for a similar name takes long.
constexpr auto kSuggestionLasts = std::chrono::seconds(1);

}  // namespace

void ServiceCaller::SayIfTwoServe(std::chrono::steady_clock::time_point second) {
  const auto services = services_.lock();
  std::unique_lock lock(mutex_);
  const std::vector<Server> servers = servers_;
  lock.unlock();
  if (!services || servers.size() < 2 || servers[1].since != second) return;
  std::string all = "Session " + servers.front().info.name();
  for (std::size_t i = 1; i < servers.size(); ++i) all += " and session " + servers[i].info.name();
  std::string sentence = "Service \"" + name_ + "\" is served by more than one session: " + all +
                         ". Calls go to the first one while it serves. Give the others another name.";
  services->log()->Write(LogLevel::kWarning, sentence);
  services->With([&](ServicePlace& place) {
    place.ReportServedTwice(servers.back().info, RequestChannel(name_), std::move(sentence));
  });
}

void ServiceCaller::SayIfCallsWait(bool said) {
  const auto services = services_.lock();
  if (!services) return;
  std::chrono::nanoseconds longest{0};
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(waiting_, [](const auto& call) { return call->done(); });
    if (waiting_.empty() || !servers_.empty()) {
      says_waiting_ = false;
      return;
    }
    for (const auto& call : waiting_) longest = std::max(longest, call->Age());
  }
  if (!said && longest >= kTimeForServers) {
    services->log()->WriteLimited(
        LogLevel::kWarning, "waits " + name_,
        "A call of service \"" + name_ + "\" waits: no session that is reached serves it." + Suggestion());
    said = true;
  }
  const std::chrono::nanoseconds pause = said ? kTimeForServers : kTimeForServers - longest;
  services->PostAt(std::chrono::steady_clock::now() + pause, [weak = weak_from_this(), said] {
    if (const auto client = weak.lock()) client->SayIfCallsWait(said);
  });
}

std::string ServiceCaller::Suggestion() {
  const auto now = std::chrono::steady_clock::now();
  const std::scoped_lock lock(suggestion_mutex_);
  if (suggested_at_ && now - *suggested_at_ < kSuggestionLasts) return suggestion_;
  std::vector<std::string> names;
  if (const auto services = services_.lock()) {
    services->With([&](ServicePlace& place) { names = place.KnownServices(); });
  }
  const std::string nearest = NearestName(name_, names);
  suggestion_ = nearest.empty() || nearest == name_ ? std::string() : " Did you mean \"" + nearest + "\"?";
  suggested_at_ = now;
  return suggestion_;
}

}  // namespace hgros

#include "transport/shm/pair/destinations.hpp"

#include <algorithm>

namespace hgros::shm {
namespace {

constexpr auto kFirstConnectPause = std::chrono::milliseconds(100);
constexpr auto kLongestConnectPause = std::chrono::milliseconds(1000);

}  // namespace

bool Destinations::Add(const std::string& place) {
  const std::scoped_lock lock(mutex_);
  if (std::ranges::any_of(destinations_, [&](const auto& known) { return known.place == place; })) return false;
  destinations_.emplace_back().place = place;
  return true;
}

void Destinations::Remove(const std::string& place) {
  const std::scoped_lock lock(mutex_);
  std::erase_if(destinations_, [&](const auto& known) { return known.place == place; });
}

std::vector<std::string> Destinations::Due(SteadyTime now, const std::function<bool(SessionId)>& is_connected) {
  std::vector<std::string> places;
  const std::scoped_lock lock(mutex_);
  for (Destination& destination : destinations_) {
    if (destination.Connected() || now < destination.next_try) continue;
    destination.pause = std::clamp(destination.pause * 2, kFirstConnectPause, kLongestConnectPause);
    destination.next_try = now + destination.pause;
    const bool connected = destination.session.value != 0 && is_connected(destination.session);
    if (!connected) places.push_back(destination.place);
  }
  return places;
}

SteadyTime Destinations::NextTry(SteadyTime latest) const {
  const std::scoped_lock lock(mutex_);
  for (const Destination& destination : destinations_) {
    if (!destination.Connected()) latest = std::min(latest, destination.next_try);
  }
  return latest;
}

void Destinations::SetPair(const std::string& place, const std::shared_ptr<Pair>& pair) {
  const std::scoped_lock lock(mutex_);
  for (Destination& destination : destinations_) {
    if (destination.place == place) destination.pair = pair;
  }
}

void Destinations::SetSession(const std::string& place, SessionId session) {
  const std::scoped_lock lock(mutex_);
  for (Destination& destination : destinations_) {
    if (destination.place == place) destination.session = session;
  }
}

void Destinations::ResetPause(const std::string& place) {
  const std::scoped_lock lock(mutex_);
  for (Destination& destination : destinations_) {
    if (destination.place == place) destination.pause = std::chrono::milliseconds(0);
  }
}

void Destinations::ForgetPair(const std::shared_ptr<Pair>& pair) {
  const std::scoped_lock lock(mutex_);
  for (Destination& destination : destinations_) {
    if (destination.pair.lock() == pair) destination.pair.reset();
  }
}

}  // namespace hgros::shm

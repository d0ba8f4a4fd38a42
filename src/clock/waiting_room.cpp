#include "hgros/internal/clock/waiting_room.hpp"

#include <algorithm>

namespace hgros {

WaitingRoom::Seat::Seat(WaitingRoom& room, Sleeper& sleeper) : room_(room), sleeper_(sleeper) {
  const std::scoped_lock lock(room_.mutex_);
  room_.sleepers_.push_back(&sleeper_);
}

WaitingRoom::Seat::~Seat() {
  const std::scoped_lock lock(room_.mutex_);
  const auto found = std::find(room_.sleepers_.begin(), room_.sleepers_.end(), &sleeper_);
  *found = room_.sleepers_.back();
  room_.sleepers_.pop_back();
}

void WaitingRoom::WakeAll() {
  const std::scoped_lock lock(mutex_);
  for (Sleeper* const sleeper : sleepers_) sleeper->Wake();
}

}  // namespace hgros

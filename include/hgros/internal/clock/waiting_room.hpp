#pragma once

#include <mutex>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/internal/clock/sleeper.hpp"

namespace hgros {

/// The sleepers that wait on a clock at the moment. Thread-safe.
class HGROS_EXPORT WaitingRoom {
 public:
  /// Registers a sleeper for the lifetime of this object.
  class HGROS_EXPORT Seat {
   public:
    Seat(WaitingRoom& room, Sleeper& sleeper);
    Seat(const Seat&) = delete;
    Seat& operator=(const Seat&) = delete;
    ~Seat();

   private:
    WaitingRoom& room_;
    Sleeper& sleeper_;
  };

  void WakeAll();

 private:
  std::mutex mutex_;
  std::vector<Sleeper*> sleepers_;
};

}  // namespace hgros

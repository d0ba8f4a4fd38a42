#pragma once

#include <functional>
#include <thread>

namespace hgros::cli {

/// Calls `tell` on a thread of its own once the user has ended the process, whatever its other threads do.
class EndNotice {
 public:
  /// `ended` can be read then: Pause::ended(). Throws Error if no descriptor is left.
  EndNotice(int ended, std::function<void()> tell);
  EndNotice(const EndNotice&) = delete;
  EndNotice& operator=(const EndNotice&) = delete;
  ~EndNotice();

 private:
  const int done_;
  std::jthread thread_;
};

}  // namespace hgros::cli

#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "doctor/evidence.hpp"
#include "robot/frames.hpp"
#include "robot/robot.hpp"

namespace hgros::cli {

/// Receives transforms, and one message of each channel with points or poses, which names a frame. Only of channels
/// whose publishers are reached by shared memory: there even a large message costs little.
class FrameSamples {
 public:
  FrameSamples(Robot& robot, const std::vector<KnownChannel>& channels);

  /// Ends the subscriptions that have got their message.
  void EndSampled();
  /// Ends all of them.
  void AddTo(Evidence& evidence);

 private:
  struct Taken {
    std::mutex mutex;
    std::map<std::string, std::string> frames;  // By channel. Guarded by mutex.
  };

  Frames frames_;
  const std::shared_ptr<Taken> taken_ = std::make_shared<Taken>();
  std::map<std::string, Subscription> subscriptions_;  // By channel.
};

}  // namespace hgros::cli

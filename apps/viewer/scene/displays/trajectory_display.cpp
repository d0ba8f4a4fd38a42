#include "foxglove/PosesInFrame.pb.h"
#include "viewer/data/frames/pose_reader.hpp"
#include "viewer/data/inbox.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/pose_history.hpp"

namespace hgros::viewer {
namespace {

using foxglove::PosesInFrame;

/// Each message holds the whole trajectory, so only the newest one is used.
class TrajectoryDisplay : public PoseHistory {
 public:
  explicit TrajectoryDisplay(const DisplayInputs& inputs)
      : subscription_(inputs.session.FromAny<PosesInFrame>(
            inputs.channel, Invoke::kSerial,
            [inbox = inbox_, wake = inputs.wake](std::shared_ptr<const PosesInFrame> poses) {
              if (inbox->Put(std::move(poses))) wake();
            },
            {.queue = Queue::Latest()})) {}

 protected:
  [[nodiscard]] PoseList::Change TakeArrived(PoseList& poses, std::string& frame) override {
    const auto arrived = inbox_->TakeAll();
    if (arrived.empty()) return PoseList::Change::kNothing;
    const PosesInFrame& newest = *arrived.back();
    frame = newest.frame_id();
    std::vector<RigidTransform> read;
    read.reserve(static_cast<std::size_t>(newest.poses_size()));
    for (const foxglove::Pose& pose : newest.poses()) read.push_back(ReadPose(pose));
    return poses.Replace(read);
  }
  [[nodiscard]] std::uint64_t received() const override { return inbox_->received(); }

 private:
  std::shared_ptr<Inbox<PosesInFrame>> inbox_ = std::make_shared<Inbox<PosesInFrame>>(1);
  Subscription subscription_;
};

}  // namespace

DisplayType TrajectoryDisplayType() {
  return {"Trajectory", {"foxglove.PosesInFrame"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<TrajectoryDisplay>(inputs);
          }};
}

}  // namespace hgros::viewer

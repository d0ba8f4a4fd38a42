#include "foxglove/Odometry.pb.h"
#include "foxglove/PoseInFrame.pb.h"
#include "viewer/data/frames/pose_reader.hpp"
#include "viewer/data/inbox.hpp"
#include "viewer/scene/display_types.hpp"
#include "viewer/scene/displays/pose_history.hpp"

namespace hgros::viewer {
namespace {

constexpr std::size_t kMostPosesWaiting = 256;

/// The last pose, or a trail of poses, of messages with a frame and a pose.
template <class Message>
class PoseDisplay : public PoseHistory {
 public:
  explicit PoseDisplay(const DisplayInputs& inputs)
      : subscription_(
            inputs.session.FromAny<Message>(inputs.channel, Invoke::kSerial,
                                            [inbox = inbox_, wake = inputs.wake](std::shared_ptr<const Message> pose) {
                                              const std::size_t bytes = pose->SpaceUsedLong();
                                              if (inbox->Put(std::move(pose), bytes)) wake();
                                            },
                                            {.queue = Queue::KeepLast(kMostPosesWaiting)})) {
    style_ = kBoth;
    axes_meters_ = 1;
    width_ = 3;
  }

  [[nodiscard]] std::vector<Setting> Settings() override {
    std::vector<Setting> all = PoseHistory::Settings();
    all.push_back({"trail", "Number of recent poses shown.", Setting::Number{&trail_, 1, 100'000, ""}});
    return all;
  }

 protected:
  [[nodiscard]] PoseList::Change TakeArrived(PoseList& poses, std::string& frame) override {
    PoseList::Change change = PoseList::Change::kNothing;
    for (const auto& pose : inbox_->TakeAll()) {
      if (pose->frame_id() != frame) poses.Clear();
      frame = pose->frame_id();
      change = std::max(change, poses.Append(ReadPose(pose->pose())));
    }
    return std::max(change, poses.KeepLast(static_cast<std::size_t>(trail_)));
  }
  [[nodiscard]] std::uint64_t received() const override { return inbox_->received(); }
  [[nodiscard]] std::uint64_t dropped() const override { return inbox_->dropped(); }

 private:
  std::shared_ptr<Inbox<Message>> inbox_ = std::make_shared<Inbox<Message>>(kMostPosesWaiting);
  Subscription subscription_;
  float trail_ = 1;
};

}  // namespace

DisplayType PoseDisplayType() {
  return {"Pose", {"foxglove.PoseInFrame"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<PoseDisplay<foxglove::PoseInFrame>>(inputs);
          }};
}

DisplayType OdometryDisplayType() {
  return {"Odometry", {"foxglove.Odometry"}, [](const DisplayInputs& inputs) -> std::unique_ptr<Display> {
            return std::make_unique<PoseDisplay<foxglove::Odometry>>(inputs);
          }};
}

}  // namespace hgros::viewer

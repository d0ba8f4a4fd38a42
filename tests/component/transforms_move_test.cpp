// Transforms in the places that a component leaves and that it comes to.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>

#include <foxglove/PoseInFrame.pb.h>

#include "hgros/component/component.hpp"
#include "hgros/component/component_move.hpp"
#include "hgros/tf/transforms.hpp"
#include "session/domain_fixture.hpp"

namespace hgros::test::transforms_move_test {
namespace {

using foxglove::PoseInFrame;

RigidTransform At(double x) { return {RigidTransform::Rotation::Identity(), Eigen::Vector3d(x, 0, 0)}; }

// Sets an edge to the x of each message, at that second.
class Walker {
 public:
  explicit Walker(Context& context) : transforms_(context.transforms()) {
    context.FromAny<PoseInFrame>("step", Invoke::kSerial, [this](const PoseInFrame& pose) {
      const double x = pose.pose().position().x();
      (void)transforms_.ToTF(Time{static_cast<std::int64_t>(x * 1e9)}, "map", "walker", At(x));
    });
  }
  [[nodiscard]] PoseInFrame Save() const { return {}; }
  void Restore(const PoseInFrame& /*state*/) {}

 private:
  Transforms& transforms_;
};
HGROS_COMPONENT(Walker, "test/Walker")

struct Looker {
  explicit Looker(Context& context) : transforms(context.transforms()) {}
  Transforms& transforms;
};
HGROS_COMPONENT(Looker, "test/Looker")

ComponentSetup WalkerSetup() { return {.name = "walker", .type = "test/Walker"}; }

struct Place : Robot {
  explicit Place(const std::string& name) : Robot("discovery: {lan: false}", name), components(*session) {
    components.Add({.name = "looker", .type = "test/Looker"});
    components.Join();
    components.Start();
  }
  [[nodiscard]] Transforms& transforms() { return components.Find<Looker>("looker")->transforms; }
  Components components;
};

class TransformsMoveTest : public DomainFixture {
 protected:
  TransformsMoveTest() {
    one_.components.Add(WalkerSetup());
    one_.components.Join();
    one_.components.Start();
    EXPECT_TRUE(outside_->WaitForSubscribers("step", 1, kPatience));
  }
  void Step(double x) {
    PoseInFrame pose;
    pose.mutable_pose()->mutable_position()->set_x(x);
    ASSERT_EQ(step_(pose), PublishStatus::kOk);
  }

  Robot outside_{"discovery: {lan: false}", "outside"};
  Publisher<PoseInFrame> step_{outside_->Advertise<PoseInFrame>("step")};
  Place one_{"one"};
  Place other_{"other"};
};

TEST_F(TransformsMoveTest, APlaceThatAComponentHasLeftHearsOfItsEdges) {
  Step(1);
  ASSERT_TRUE(Await([&] { return one_.transforms().stats().sent_transforms == 1; }));
  {
    ArrivingComponent arriving(other_.components, WalkerSetup(), [] {});
    ASSERT_TRUE(outside_->WaitForSubscribers("step", 2, kPatience));
    LeavingComponent leaving(one_.components, "walker", [] {});
    arriving.Restore(leaving.Hold(kPatience, other_.session->id()));
    arriving.Begin();
    leaving.Leave();
  }
  ASSERT_TRUE(other_->WaitForSubscribers(kTransformsChannel, 2, kPatience)) << "itself, and the old place";
  Step(2);
  ASSERT_TRUE(Await([&] { return one_.transforms().stats().received_transforms == 1; }));
  EXPECT_TRUE(Await([&] { return one_.transforms().FromTF("map", "walker")->T_target_source.translation.x() == 2; }));
}

TEST_F(TransformsMoveTest, APlaceHearsOfTransformsAsSoonAsAComponentComes) {
  Transforms far(*outside_.session);
  const ArrivingComponent arriving(other_.components, WalkerSetup(), [] {});
  EXPECT_TRUE(Await([&] {
    EXPECT_TRUE(far.ToTF(Time{1}, "map", "far", At(1)));
    return other_.transforms().stats().received_transforms > 0;
  }));
}

TEST_F(TransformsMoveTest, AComponentThatOnlySetsTransformsHearsNothing) {
  Step(1);
  ASSERT_TRUE(Await([&] { return one_.transforms().stats().sent_transforms == 1; }));
  Transforms far(*outside_.session);
  ASSERT_TRUE(far.ToTF(Time{1}, "map", "far", At(1)));
  EXPECT_FALSE(outside_->WaitForSubscribers(kTransformsChannel, 1, std::chrono::milliseconds(50)));
}

}  // namespace
}  // namespace hgros::test::transforms_move_test

// Transforms in the places that a component leaves and that it comes to.
#include <cstdint>

#include <foxglove/PoseInFrame.pb.h>

#include "hgros/component/component.hpp"
#include "hgros/component/component_move.hpp"
#include "hgros/tf/transforms.hpp"
#include "session/domain_fixture.hpp"
#include "tf/static_messages.hpp"

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

// Two sessions that set one static edge are told after the time-out.
constexpr const char* kAlone = "{discovery: {lan: false}, network: {heartbeat_ms: 100, peer_timeout_ms: 2000}}";

ComponentSetup WalkerSetup() { return {.name = "walker", .type = "test/Walker"}; }

struct Place : Robot {
  explicit Place(const std::string& name) : Robot(kAlone, name), components(*session) {}
  void Run(const ComponentSetup& setup) {
    components.Add(setup);
    components.Join();
    components.Start();
  }
  Components components;
};

struct LookingPlace : Place {
  explicit LookingPlace(const std::string& name) : Place(name) { Run({.name = "looker", .type = "test/Looker"}); }
  [[nodiscard]] Transforms& transforms() { return components.Find<Looker>("looker")->transforms; }
};

class TransformsMoveTest : public DomainFixture {
 protected:
  TransformsMoveTest() {
    one_.Run(WalkerSetup());
    EXPECT_TRUE(outside_->WaitForSubscribers("step", 1, kPatience));
  }
  void Step(double x) {
    PoseInFrame pose;
    pose.mutable_pose()->mutable_position()->set_x(x);
    ASSERT_EQ(step_(pose), PublishStatus::kOk);
  }

  Robot outside_{kAlone, "outside"};
  Publisher<PoseInFrame> step_{outside_->Advertise<PoseInFrame>("step")};
  LookingPlace one_{"one"};
  LookingPlace other_{"other"};
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

// Static edges of components that move.
// Sets edges from "base" in its constructor, in Activate, and to the frame of a message at the x of its pose.
class Mount {
 public:
  explicit Mount(Context& context) : transforms_(context.transforms()) {
    (void)transforms_.ToStaticTF("base", "plate", At(1));
    (void)transforms_.ToStaticTF("base", "head", At(1));
    context.FromAny<PoseInFrame>("turn", Invoke::kSerial, [this](const PoseInFrame& pose) {
      (void)transforms_.ToStaticTF("base", pose.frame_id(), At(pose.pose().position().x()));
    });
  }
  void Activate() { (void)transforms_.ToStaticTF("base", "arm", At(2)); }
  [[nodiscard]] PoseInFrame Save() const { return {}; }
  void Restore(const PoseInFrame& /*state*/) {}

 private:
  Transforms& transforms_;
};
HGROS_COMPONENT(Mount, "test/Mount")

ComponentSetup MountSetup() { return {.name = "mount", .type = "test/Mount"}; }

using Edges = StaticMessages::Edges;

class StaticEdgesMoveTest : public DomainFixture {
 protected:
  StaticEdgesMoveTest() {
    one_.Run(MountSetup());
    EXPECT_TRUE(outside_->WaitForSubscribers("turn", 1, kPatience));
  }
  void Turn(const std::string& child, double x) {
    PoseInFrame pose;
    pose.set_frame_id(child);
    pose.mutable_pose()->mutable_position()->set_x(x);
    ASSERT_EQ(turn_(pose), PublishStatus::kOk);
  }
  static void Move(Place& from, Place& to) {
    ArrivingComponent arriving(to.components, MountSetup(), [] {});
    LeavingComponent leaving(from.components, "mount", [] {});
    arriving.Restore(leaving.Hold(kPatience, to.session->id()));
    arriving.Begin();
    leaving.Leave();
  }

  Robot outside_{kAlone, "outside"};
  Publisher<PoseInFrame> turn_{outside_->Advertise<PoseInFrame>("turn")};
  Place one_{"one"};
  Place other_{"other"};
};

TEST_F(StaticEdgesMoveTest, LateSessionsGetThemFromTheNewPlaceOnly) {
  StaticMessages early(*outside_.session);
  Turn("laser", 3);
  Turn("head", 4);
  const Edges all = {{"plate", 1}, {"head", 4}, {"arm", 2}, {"laser", 3}};
  ASSERT_TRUE(early.Gets(all));
  Place* from = &one_;
  Place* to = &other_;
  for (int move = 0; move < 3; ++move, std::swap(from, to)) {
    Move(*from, *to);
    const Robot late{kAlone, "late"};
    StaticMessages seen(*late.session);
    ASSERT_TRUE(seen.Gets({}) && seen.Gets(all));
    for (const Edges& edges : seen.all()) EXPECT_TRUE(edges.empty() || edges == all);
  }
}

TEST_F(StaticEdgesMoveTest, NobodySaysThatTwoSessionsSetThem) {
  Transforms looking(*outside_.session);
  (void)looking.tree();
  Place* from = &one_;
  Place* to = &other_;
  for (int move = 0; move < 3; ++move, std::swap(from, to)) Move(*from, *to);
  // This is so, and told after the other would have been.
  Robot second{kAlone, "second"};
  Transforms shared(*second.session);
  ASSERT_TRUE(looking.ToStaticTF("base", "camera", At(5)));
  ASSERT_TRUE(shared.ToStaticTF("base", "camera", At(6)));
  EXPECT_TRUE(Await([&] { return outside_.Said("Two sessions set the edge from \"base\" to \"camera\""); }));
  EXPECT_EQ(outside_.Count("Two sessions set the edge"), 1U);
  EXPECT_EQ(looking.FromTF("base", "plate")->T_target_source.translation.x(), 1);
  const auto edges = looking.tree().Edges();
  const auto plate = std::ranges::find(edges, "plate", [&](const EdgeSnapshot& edge) { return edge.child; });
  ASSERT_NE(plate, edges.end());
  EXPECT_EQ(plate->publisher, "other");
}

TEST_F(StaticEdgesMoveTest, TheyStayIfTheMoveIsAbandoned) {
  StaticMessages early(*outside_.session);
  Turn("plate", 3);
  const Edges all = {{"plate", 3}, {"head", 1}, {"arm", 2}};
  ASSERT_TRUE(early.Gets(all));
  const std::size_t before = early.all().size();
  {
    ArrivingComponent arriving(other_.components, MountSetup(), [] {});
    LeavingComponent leaving(one_.components, "mount", [] {});
    arriving.Restore(leaving.Hold(kPatience, other_.session->id()));
  }
  const Robot late{kAlone, "late"};
  StaticMessages seen(*late.session);
  ASSERT_TRUE(seen.Gets(all));
  EXPECT_TRUE(Await([&] { return early.all().back() == all; }));
  const std::vector<Edges> got = early.all();
  for (std::size_t i = before; i < got.size(); ++i) EXPECT_TRUE(got[i].empty() || got[i] == all);
}

}  // namespace
}  // namespace hgros::test::transforms_move_test

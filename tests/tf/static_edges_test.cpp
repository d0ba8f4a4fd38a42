#include <gmock/gmock.h>
#include <unistd.h>

#include "hgros/tf/transforms.hpp"
#include "hgros/tf/transforms_parts.hpp"
#include "session/domain_fixture.hpp"
#include "tf/static_messages.hpp"
#include "tf/tf_fixture.hpp"

namespace hgros::static_edges_test {
namespace {

using foxglove::FrameTransforms;
using test::Await;
using test::kPatience;
using test::Robot;
using test::Shift;
using test::StaticMessages;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

class StaticEdges : public test::DomainFixture {
 protected:
  // A component of a session.
  struct Own {
    explicit Own(Transforms& shared) : transforms(TransformsParts(shared).ForComponent()), parts(*transforms) {}
    std::unique_ptr<Transforms> transforms;
    TransformsParts parts;
  };
  static std::vector<std::string> Children(const std::vector<StampedEdge>& edges) {
    std::vector<std::string> children;
    for (const StampedEdge& edge : edges) children.push_back(edge.child);
    return children;
  }

  Robot a_{"", "a"};
  Robot b_{"", "b"};
};

TEST_F(StaticEdges, LateSessionsGetNoneThatAComponentWithholds) {
  Transforms shared(*a_.session, {.batch = Duration(0)});
  Own one(shared);
  Own other(shared);
  ASSERT_TRUE(shared.ToStaticTF("base", "mast", Shift(1)));
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "laser", Shift(2)));
  ASSERT_TRUE(other.transforms->ToStaticTF("base", "camera", Shift(3)));
  const StaticMessages early(*b_.session);
  ASSERT_TRUE(early.Gets({{"mast", 1}, {"laser", 2}, {"camera", 3}}));
  EXPECT_TRUE(one.parts.Withhold());
  EXPECT_TRUE(early.Gets({{"mast", 1}, {"camera", 3}}));
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "lamp", Shift(4)));
  ASSERT_TRUE(other.transforms->ToStaticTF("base", "mast", Shift(5)));
  EXPECT_THAT(Children(one.parts.Withheld()), ElementsAre("laser", "lamp"));
  const Robot late{"", "late"};
  const StaticMessages seen(*late.session);
  EXPECT_TRUE(seen.Gets({{"mast", 5}, {"camera", 3}}));
  EXPECT_EQ(seen.all().size(), 1U);
  one.parts.Release();
  EXPECT_TRUE(seen.Gets({{"mast", 5}, {"camera", 3}, {"laser", 2}, {"lamp", 4}}));
  EXPECT_EQ(seen.all().size(), 2U) << "in one message";
  EXPECT_FALSE(Own(shared).parts.Withhold()) << "it had none";
}

TEST_F(StaticEdges, TheLastOneThatIsWithheldLeavesAnEmptyMessage) {
  Transforms shared(*a_.session);
  Own one(shared);
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "laser", Shift(1)));
  EXPECT_TRUE(one.parts.Withhold());
  const StaticMessages late(*b_.session);
  EXPECT_TRUE(late.Gets({}));
  EXPECT_THAT(late.all(), ElementsAre(IsEmpty()));
}

TEST_F(StaticEdges, TheOneThatHasSetAnEdgeLastWithholdsIt) {
  Transforms shared(*a_.session);
  Own one(shared);
  Own other(shared);
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "laser", Shift(1)));
  ASSERT_TRUE(other.transforms->ToStaticTF("base", "laser", Shift(2)));
  EXPECT_FALSE(one.parts.Withhold());
  EXPECT_TRUE(other.parts.Withhold());
}

TEST_F(StaticEdges, ThoseOfTheConstructorAreNotForAnotherPlaceButComeBack) {
  Transforms shared(*a_.session);
  Own one(shared);
  one.parts.SetConstructing(true);
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "laser", Shift(1)));
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "camera", Shift(2)));
  one.parts.SetConstructing(false);
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "camera", Shift(3)));
  EXPECT_TRUE(one.parts.Withhold());
  EXPECT_THAT(Children(one.parts.Withheld()), ElementsAre("camera"));
  one.parts.Release();
  EXPECT_TRUE(one.parts.Withhold());
  EXPECT_THAT(Children(one.parts.Withheld()), ElementsAre("camera"));
  one.parts.Release();
  const StaticMessages late(*b_.session);
  EXPECT_TRUE(late.Gets({{"laser", 1}, {"camera", 3}}));
}

TEST_F(StaticEdges, AWithheldOneReplacesNoneInTheTreeAndIsToldIfTheTreeRefusesItWhenItIsReleased) {
  Transforms shared(*a_.session);
  ASSERT_TRUE(shared.ToStaticTF("base", "laser", Shift(1)));
  ASSERT_TRUE(shared.ToStaticTF("laser", "lens", Shift(1)));
  Own one(shared);
  EXPECT_FALSE(one.parts.Withhold());
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "laser", Shift(2)));
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "lamp", Shift(3)));
  ASSERT_TRUE(one.transforms->ToStaticTF("base", "lens", Shift(2)));
  EXPECT_EQ(shared.FromTF("base", "laser")->T_target_source.translation.x(), 1);
  EXPECT_EQ(shared.FromTF("base", "lamp")->T_target_source.translation.x(), 3);
  one.parts.Release();
  EXPECT_EQ(shared.FromTF("base", "laser")->T_target_source.translation.x(), 2);
  EXPECT_TRUE(a_.Said("An edge of a component that has moved here: ") && a_.Said("keeps its parent"));
  const StaticMessages late(*b_.session);
  EXPECT_TRUE(late.Gets({{"laser", 2}, {"lamp", 3}, {"lens", 1}}));
}

// They are told after the time in which a peer that says nothing is gone.
TEST_F(StaticEdges, TwoSessionsThatSetOneAreTold) {
  const std::string soon = "network: {heartbeat_ms: 100, peer_timeout_ms: 2000}";
  Robot a{soon, "a"};
  Robot b{soon, "b"};
  Robot looker{soon, "looker"};
  Transforms one(*a.session);
  Transforms two(*b.session);
  Transforms looking(*looker.session);
  for (Transforms* transforms : {&one, &two, &looking}) (void)transforms->tree();
  ASSERT_TRUE(one.ToStaticTF("base", "laser", Shift(1)));
  ASSERT_TRUE(two.ToStaticTF("base", "laser", Shift(2)));
  for (Robot* robot : {&a, &b, &looker}) {
    EXPECT_TRUE(Await([&] { return robot->Said("Two sessions set the edge from \"base\" to \"laser\""); }));
    EXPECT_TRUE(robot->Said("b:" + std::to_string(getpid())));
  }
  ASSERT_TRUE(two.ToStaticTF("base", "laser", Shift(3)));
  ASSERT_TRUE(two.ToStaticTF("base", "camera", Shift(3)));
  ASSERT_TRUE(one.ToStaticTF("base", "camera", Shift(3)));
  EXPECT_TRUE(Await([&] { return looking.stats().shared_edges == 2; }));
  EXPECT_EQ(looker.Count("\"base\" to \"laser\""), 1U);
}

// The real one is told after the other would have been.
TEST_F(StaticEdges, OneThatMovesToAnotherSessionIsNotShared) {
  Transforms one(*a_.session, {.batch = Duration(0)});
  Transforms two(*b_.session, {.batch = Duration(0)});
  Robot looker{"", "looker"};
  Transforms looking(*looker.session);
  for (Transforms* transforms : {&one, &two, &looking}) (void)transforms->tree();
  const auto found = [](Transforms& transforms, const std::string& child) {
    const TransformResult result = transforms.FromTF("base", child);
    return result ? result->T_target_source.translation.x() : 0;
  };
  const auto arrive = [&](const std::string& child, double x) {
    for (Transforms* transforms : {&one, &two, &looking}) {
      ASSERT_TRUE(Await([&] { return found(*transforms, child) == x; })) << child;
    }
  };
  Own before(one);
  Own after(two);
  ASSERT_TRUE(before.transforms->ToStaticTF("base", "laser", Shift(1)));
  ASSERT_TRUE(before.transforms->ToStaticTF("base", "lamp", Shift(1)));
  ASSERT_NO_FATAL_FAILURE(arrive("lamp", 1));
  // Both have it for a moment: a message has overtaken the other.
  ASSERT_TRUE(after.transforms->ToStaticTF("base", "laser", Shift(2)));
  ASSERT_NO_FATAL_FAILURE(arrive("laser", 2));
  EXPECT_TRUE(before.parts.Withhold());
  // One after the other, and back.
  ASSERT_TRUE(after.transforms->ToStaticTF("base", "lamp", Shift(2)));
  ASSERT_NO_FATAL_FAILURE(arrive("lamp", 2));
  EXPECT_TRUE(after.parts.Withhold());
  before.parts.Release();
  ASSERT_NO_FATAL_FAILURE(arrive("lamp", 1));

  ASSERT_TRUE(one.ToStaticTF("base", "camera", Shift(3)));
  ASSERT_NO_FATAL_FAILURE(arrive("camera", 3));
  ASSERT_TRUE(two.ToStaticTF("base", "camera", Shift(4)));
  for (Transforms* transforms : {&one, &two, &looking}) {
    EXPECT_TRUE(Await([&] { return transforms->stats().shared_edges == 1; }));
  }
  for (Robot* robot : {&a_, &b_, &looker}) {
    EXPECT_TRUE(robot->Said("Two sessions set the edge from \"base\" to \"camera\""));
    EXPECT_EQ(robot->Count("Two sessions set the edge"), 1U);
  }
}

}  // namespace
}  // namespace hgros::static_edges_test

#include "hosting/move_message.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <string>

#include "hgros/base/bytes.hpp"

namespace hgros::cli {
namespace {

TEST(MoveMessage, CarriesStaticEdgesAndWhatIsLatched) {
  MovingState moving;
  moving.from = SessionId{7};
  const auto data = std::make_shared<const std::string>("abc");
  moving.latched.push_back({"map", 5, {AsBytes(*data), data}});
  moving.static_edges.push_back(
      {"base", "laser", {}, {RigidTransform::Rotation(0.5, 0.1, 0.2, 0.3), Eigen::Vector3d(1, 2, 3)}});
  moving.static_edges.push_back({"base", "lamp", {}, {}});
  RunOrder::Move move;
  Write(moving, move);
  RunOrder::Move read;
  ASSERT_TRUE(read.ParseFromString(move.SerializeAsString()));
  read.add_static_edges()->set_child("none: it has no pose");
  const MovingState state = StateOf(read);
  EXPECT_EQ(state.from, moving.from);
  ASSERT_EQ(state.latched.size(), 1U);
  EXPECT_EQ(state.latched[0].channel, "map");
  EXPECT_EQ(AsText(state.latched[0].data.bytes), "abc");
  ASSERT_EQ(state.static_edges.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const StampedEdge& got = state.static_edges[i];
    const StampedEdge& sent = moving.static_edges[i];
    EXPECT_EQ(got.parent, sent.parent);
    EXPECT_EQ(got.child, sent.child);
    EXPECT_EQ(got.T_parent_child.translation, sent.T_parent_child.translation);
    EXPECT_EQ(got.T_parent_child.rotation.coeffs(), sent.T_parent_child.rotation.coeffs());
  }
}

}  // namespace
}  // namespace hgros::cli

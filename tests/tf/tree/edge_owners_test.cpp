#include "tf/tree/edge_owners.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>

namespace hgros::tf {
namespace {

TEST(EdgeOwners, ForgetsSessionsThatAreGone) {
  EdgeOwners owners;
  const EdgeOwners::Moment now{};
  std::uint32_t last = 0;
  while (!owners.is_crowded()) {
    ASSERT_LT(last, 1000U);
    ++last;
    EXPECT_FALSE(owners.NoteStatic(FrameId{0}, FrameId{last}, SessionId{last}, now));
  }
  owners.KeepSessions({SessionId{last}});
  EXPECT_FALSE(owners.is_crowded());
  // The one that is there can withdraw its edge, so another one does not share it.
  owners.Withdraw(SessionId{last}, FrameId{last});
  EXPECT_FALSE(owners.NoteStatic(FrameId{0}, FrameId{last}, SessionId{last + 1}, now));
  EXPECT_TRUE(owners.NoteStatic(FrameId{0}, FrameId{last}, SessionId{last + 2}, now));
}

class MovingEdgeOwners : public testing::Test {
 protected:
  bool Set(std::uint32_t by, std::chrono::milliseconds after = std::chrono::milliseconds(10)) {
    now_ += after;
    return owners_.NoteMoving(FrameId{1}, SessionId{by}, now_).has_value();
  }

 private:
  EdgeOwners owners_;
  EdgeOwners::Moment now_{};
};

TEST_F(MovingEdgeOwners, OneThatASecondSessionSetsNowAndThenIsShared) {
  const auto turn = [this] {
    EXPECT_FALSE(Set(2));
    bool shared = false;
    for (int i = 0; i < 100; ++i) shared = Set(1) || shared;
    return shared;
  };
  EXPECT_FALSE(Set(1));
  EXPECT_FALSE(turn());
  EXPECT_FALSE(turn());
  EXPECT_TRUE(turn());
}

TEST_F(MovingEdgeOwners, OneThatMovesToAnotherSessionAndBackIsNotShared) {
  for (std::uint32_t move = 0; move < 10; ++move) {
    for (int i = 0; i < 10; ++i) EXPECT_FALSE(Set(1 + move % 2));
  }
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(Set(1, std::chrono::seconds(6)));
    EXPECT_FALSE(Set(2, std::chrono::seconds(6)));
  }
}

TEST_F(MovingEdgeOwners, OneOfASessionThatRestartsIsNotShared) {
  for (std::uint32_t by = 1; by < 20; ++by) EXPECT_FALSE(Set(by));
}

}  // namespace
}  // namespace hgros::tf

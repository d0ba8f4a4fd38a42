#include "hgros/base/session_name.hpp"

#include <gtest/gtest.h>

namespace hgros {
namespace {

TEST(SessionName, NamesProcessAndHost) {
  EXPECT_EQ(SessionName(SessionId{0x1234}, "talker", 42, "robot"), "0000000000001234 (talker, process 42 on robot)");
}

TEST(SessionName, OmitsAnUnknownHost) {
  EXPECT_EQ(SessionName(SessionId{0x1234}, "talker", 42), "0000000000001234 (talker, process 42)");
}

}  // namespace
}  // namespace hgros

#include "robot/channel_type.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "hgros/run_time_types.hpp"
#include "support/error_of.hpp"

namespace hgros::cli {
namespace {

TEST(ChannelType, RefusesSchemasThatDescribeNoType) {
  for (const std::string& set : {std::string(), std::string("\x1b[31m\xff"), std::string(2'000'000, '\n')}) {
    MessageSchema schema = GripSchema();
    schema.descriptor_set = set;
    EXPECT_THAT(test::ErrorOf([&] { return TypeFrom(schema); }),
                testing::StartsWith("Messages of robot.Grip cannot be written: The publisher's schema"));
  }
  EXPECT_NE(TypeFrom(GripSchema()).type, nullptr);
}

}  // namespace
}  // namespace hgros::cli

#include "messages/field_path.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <foxglove/LaserScan.pb.h>

#include "arguments/arguments.hpp"
#include "messages/message_text.hpp"

namespace hgros::cli {
namespace {

using foxglove::LaserScan;

std::string FaultOf(const std::string& path) {
  try {
    (void)FieldPath::Parse(path, *LaserScan::descriptor());
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

TEST(FieldPath, FindsFieldsAndItems) {
  LaserScan scan;
  scan.mutable_pose()->mutable_position()->set_x(1.5);
  scan.add_ranges(2);
  scan.add_ranges(3);
  const auto text = [&](const std::string& path) -> std::string {
    const auto place = FieldPath::Parse(path, *LaserScan::descriptor()).Find(scan);
    return place ? PlainText(*place) : "none";
  };
  EXPECT_EQ(text("pose.position.x"), "1.5");
  EXPECT_EQ(text("ranges[1]"), "3");
  EXPECT_EQ(text("ranges[2]"), "none");
  EXPECT_EQ(text("ranges"), "[2,3]");
  EXPECT_EQ(text("timestamp"), "none");
  EXPECT_EQ(text("pose.orientation.w"), "none");
}

TEST(FieldPath, SaysWhatIsWrong) {
  EXPECT_EQ(FaultOf("pose.positon"), "foxglove.Pose has no field \"positon\". Did you mean position?");
  EXPECT_EQ(FaultOf("ranges[x]"), "\"ranges[x]\" is not a field with an index. Write it as ranges[0].");
  EXPECT_EQ(FaultOf("ranges[99999999999999999999]"),
            "The index in \"ranges[99999999999999999999]\" is too large. At most 2147483647 is possible.");
  EXPECT_EQ(FaultOf("frame_id[0]"), "\"frame_id\" is not a list, so it has no index.");
  EXPECT_EQ(FaultOf("frame_id.x"), "\"frame_id\" has no fields, so it has no \"x\".");
  EXPECT_EQ(FaultOf("ranges.x"), "\"ranges\" is a list. Write which of its items is meant, such as ranges[0].x.");
  EXPECT_EQ(FaultOf("pose."), "A field path must not end with a dot.");
  for (const char* path : {"[", "]", "[]", "a[", ".", "..", "ranges[-1]", "ranges[99999999999]", "ranges[1"}) {
    EXPECT_NE(FaultOf(path), "") << path;
  }
}

}  // namespace
}  // namespace hgros::cli

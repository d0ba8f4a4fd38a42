#include "viewer/data/messages/field_path.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "foxglove/LaserScan.pb.h"
#include "foxglove/Log.pb.h"
#include "hgros/codec/dynamic_schema.hpp"
#include "hgros/codec/message.hpp"
#include "viewer/data/messages/message_tree.hpp"

namespace hgros::viewer {
namespace {

using foxglove::LaserScan;
using ::testing::Contains;
using ::testing::HasSubstr;

/// A message as read by a program that was built without its type.
template <class T>
struct Dynamic {
  explicit Dynamic(const T& message) {
    std::string fault;
    schema = DynamicSchema::Build(SchemaOf(TypeOf<T>()), fault);
    read = schema->Read(AsBytes(message.SerializeAsString()));
  }
  std::shared_ptr<const DynamicSchema> schema;
  std::unique_ptr<google::protobuf::Message> read;
};

LaserScan Scan() {
  LaserScan scan;
  scan.mutable_timestamp()->set_seconds(12);
  scan.mutable_timestamp()->set_nanos(500'000'000);
  scan.set_frame_id("laser");
  scan.mutable_pose()->mutable_position()->set_x(3);
  scan.set_start_angle(-1);
  for (const double range : {1.0, 2.0, 4.0}) scan.add_ranges(range);
  return scan;
}

std::optional<double> Value(const Dynamic<LaserScan>& scan, std::string_view path) {
  std::string fault;
  const auto parsed = FieldPath::Parse(path, scan.schema->descriptor(), fault);
  EXPECT_TRUE(parsed) << fault;
  return parsed ? parsed->Read(*scan.read) : std::nullopt;
}

TEST(ViewerFieldPath, ReadsNumbersAtAnyDepth) {
  const Dynamic scan(Scan());
  EXPECT_EQ(Value(scan, "pose.position.x"), 3);
  EXPECT_EQ(Value(scan, "start_angle"), -1);
  EXPECT_EQ(Value(scan, "ranges[2]"), 4);
  EXPECT_EQ(Value(scan, "timestamp"), 12.5);
  EXPECT_EQ(Value(scan, "timestamp.nanos"), 500'000'000);
  EXPECT_EQ(Value(scan, "ranges[3]"), std::nullopt);
  EXPECT_EQ(Value(scan, "pose.orientation.w"), std::nullopt) << "no orientation is set";
  foxglove::Log log;
  log.set_level(foxglove::Log::ERROR);
  const Dynamic said(log);
  std::string fault;
  EXPECT_EQ(FieldPath::Parse("level", said.schema->descriptor(), fault)->Read(*said.read), 4);
}

TEST(ViewerFieldPath, ExplainsWhyThereIsNoNumber) {
  const auto fault = [](std::string_view path) {
    std::string said;
    EXPECT_FALSE(FieldPath::Parse(path, *LaserScan::descriptor(), said)) << path;
    return said;
  };
  EXPECT_EQ(fault("pose.position.w"), "foxglove.Vector3 has no field \"w\".");
  EXPECT_THAT(fault("ranges"), HasSubstr("name the element, as in ranges[0]"));
  EXPECT_THAT(fault("pose[0].position"), HasSubstr("not a list"));
  EXPECT_THAT(fault("frame_id"), HasSubstr("is not a number"));
  EXPECT_THAT(fault("pose"), HasSubstr("is not a number"));
  EXPECT_THAT(fault("start_angle.x"), HasSubstr("has no fields"));
  for (const char* broken :
       {"", ".", "ranges[", "ranges[]", "ranges[-1]", "ranges[1", "ranges[1]x", "ranges[99999999999]"}) {
    EXPECT_NE(fault(broken), "") << broken;
  }
}

TEST(ViewerFieldPath, ListsAllPathsOfNumbers) {
  const auto paths = NumberPaths(*LaserScan::descriptor(), 100);
  EXPECT_THAT(paths, Contains("pose.position.x"));
  EXPECT_THAT(paths, Contains("ranges[0]"));
  EXPECT_THAT(paths, Contains("timestamp"));
  EXPECT_THAT(paths, testing::Not(Contains("frame_id")));
  for (const std::string& path : paths) {
    std::string fault;
    EXPECT_TRUE(FieldPath::Parse(path, *LaserScan::descriptor(), fault)) << fault;
  }
  EXPECT_EQ(NumberPaths(*LaserScan::descriptor(), 3).size(), 3U);
}

std::vector<std::string> Lines(const google::protobuf::Message& message, const TreeView& view) {
  std::vector<std::string> lines;
  for (const TreeRow& row : RowsOf(message, view)) {
    lines.push_back(std::string(static_cast<std::size_t>(row.depth), '>') + row.name + "=" + row.value);
  }
  return lines;
}

TEST(MessageTree, ShowsFoldedAndUnfoldedRows) {
  const Dynamic scan(Scan());
  EXPECT_THAT(Lines(*scan.read, {}), testing::IsSupersetOf({"frame_id=laser", "pose=Pose", "ranges=3 elements",
                                                            "intensities=0 elements", "start_angle=-1"}));
  const TreeView view{.opened = {"pose", "pose.position", "ranges"}};
  const auto lines = Lines(*scan.read, view);
  EXPECT_THAT(lines, testing::IsSupersetOf({">position=Vector3", ">>x=3", ">orientation=not set", ">[2]=4"}));
}

TEST(MessageTree, PathsOfItsNumbersCanBePlotted) {
  const Dynamic scan(Scan());
  const TreeView view{.opened = {"pose", "pose.position", "ranges", "timestamp"}};
  int numbers = 0;
  for (const TreeRow& row : RowsOf(*scan.read, view)) {
    if (!row.number) continue;
    ++numbers;
    EXPECT_TRUE(Value(scan, row.path)) << row.path;
  }
  EXPECT_GE(numbers, 9);
}

TEST(MessageTree, LimitsRowsAndTexts) {
  LaserScan scan;
  for (int i = 0; i < 10'000; ++i) scan.add_ranges(i);
  scan.set_frame_id(std::string(10'000, 'x') + "\n");
  TreeView view{.opened = {"ranges"}, .most_elements = 10, .most_text = 5};
  const auto lines = Lines(scan, view);
  EXPECT_THAT(lines, Contains(">=9990 more"));
  EXPECT_THAT(lines, Contains("frame_id=xxxxx... (10001 bytes)"));
  view.most_elements = 5000;
  view.most_rows = 50;
  const auto rows = RowsOf(scan, view);
  ASSERT_EQ(rows.size(), 51U);
  EXPECT_EQ(rows.back().value, "more rows are not shown");
}

}  // namespace
}  // namespace hgros::viewer

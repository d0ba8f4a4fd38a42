#include "messages/filter.hpp"

#include <gtest/gtest.h>

#include <foxglove/LaserScan.pb.h>
#include <foxglove/Log.pb.h>

#include "arguments/arguments.hpp"

namespace hgros::cli {
namespace {

using foxglove::LaserScan;

LaserScan Scan() {
  LaserScan scan;
  scan.set_frame_id("laser_2");
  scan.set_start_angle(-1.5);
  scan.mutable_pose()->mutable_position()->set_x(2);
  for (const double range : {1.0, 2.0, 3.0}) scan.add_ranges(range);
  return scan;
}

bool Accepts(const std::string& text) { return Filter(text, *LaserScan::descriptor()).Accepts(Scan()); }

TEST(Filter, ComparesFieldsWithNumbersAndTexts) {
  EXPECT_TRUE(Accepts("start_angle == -1.5"));
  EXPECT_TRUE(Accepts("pose.position.x > 1.5 && pose.position.x <= 2"));
  EXPECT_FALSE(Accepts("pose.position.x != 2"));
  EXPECT_TRUE(Accepts("frame_id == 'laser_2'"));
  EXPECT_TRUE(Accepts("frame_id =~ \"^laser_[0-9]$\""));
  EXPECT_TRUE(Accepts("ranges[2] > ranges[1]"));
  EXPECT_TRUE(Accepts("size(ranges) == 3 && size(frame_id) == 7"));
}

TEST(Filter, ComparesEnumsAndTimesByValue) {
  foxglove::Log log;
  log.set_level(foxglove::Log::ERROR);
  log.mutable_timestamp()->set_seconds(1700000000);
  log.mutable_timestamp()->set_nanos(250000000);
  const auto accepts = [&](const std::string& text) { return Filter(text, *foxglove::Log::descriptor()).Accepts(log); };
  EXPECT_TRUE(accepts("level >= 'WARNING'"));
  EXPECT_TRUE(accepts("level == 4 && level == 'ERROR' && 'FATAL' > level"));
  EXPECT_TRUE(accepts("timestamp > '2023-11-14T22:13:20Z' && timestamp < '2023-11-14T22:13:20.5Z'"));
  EXPECT_TRUE(accepts("timestamp > 1700000000"));
  EXPECT_THROW(accepts("level == 'EROR'"), UsageError);
  EXPECT_THROW(accepts("timestamp > 'tomorrow'"), UsageError);
  log.set_message(std::string(1'000'000, 'a'));
  EXPECT_FALSE(accepts("message =~ 'a.*b'"));
  EXPECT_TRUE(accepts("size(message) == 1000000"));
}

TEST(Filter, JoinsConditions) {
  EXPECT_TRUE(Accepts("!(start_angle > 0) && (end_angle == 1 || frame_id)"));
  EXPECT_FALSE(Accepts("end_angle || false"));
  EXPECT_TRUE(Accepts("true || end_angle > 1 && false"));
}

TEST(Filter, IsFalseForWhatIsNotThere) {
  EXPECT_FALSE(Accepts("ranges[7] < 5"));
  EXPECT_FALSE(Accepts("ranges[7] >= 5"));
  EXPECT_FALSE(Accepts("pose.orientation.w != 5"));
}

TEST(Filter, RefusesWhatItCannotRead) {
  for (const char* text : {"range_max > -nan",
                           "range_max < +-inf",
                           "",
                           "start_angle =",
                           "start_angle = 1",
                           "(start_angle",
                           "start_angle > ",
                           "nothing == 1",
                           "frame_id =~ frame_id",
                           "frame_id =~ \"[\"",
                           "'open",
                           "1 2",
                           "size(3)",
                           "size(start_angle)",
                           "size(timestamp)",
                           "ranges == 1",
                           "2 < ranges",
                           "start_angle )",
                           "&&",
                           "-",
                           "5 > > 3"}) {
    EXPECT_THROW(Accepts(text), UsageError) << text;
  }
  EXPECT_THROW(Accepts(std::string(100000, '(')), UsageError);
  EXPECT_THROW(Accepts(std::string(100000, '!')), UsageError);
}

}  // namespace
}  // namespace hgros::cli

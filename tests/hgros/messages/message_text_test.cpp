#include "messages/message_text.hpp"

#include <gtest/gtest.h>

#include <limits>

#include <foxglove/FrameTransforms.pb.h>
#include <foxglove/LaserScan.pb.h>
#include <foxglove/RawImage.pb.h>

#include "messages/known_types.hpp"

namespace hgros::cli {
namespace {

std::string YamlOf(const google::protobuf::Message& message, TextLimits limits = {}) {
  std::string text;
  AppendYaml(text, {&message, nullptr, -1}, limits);
  return text;
}
std::string JsonOf(const google::protobuf::Message& message) {
  Json json;
  WriteJson(json, {&message, nullptr, -1});
  return std::string(json.text());
}

TEST(MessageText, WritesNestedMessagesAndLists) {
  foxglove::FrameTransforms transforms;
  foxglove::FrameTransform& one = *transforms.add_transforms();
  one.set_parent_frame_id("map");
  one.set_child_frame_id("base 1");
  one.mutable_translation()->set_x(0.1);
  one.mutable_timestamp()->set_seconds(1700000000);
  one.mutable_timestamp()->set_nanos(250000000);
  (void)transforms.add_transforms();
  EXPECT_EQ(YamlOf(transforms),
            "transforms:\n"
            "- timestamp: 2023-11-14T22:13:20.25Z\n"
            "  parent_frame_id: map\n"
            "  child_frame_id: \"base 1\"\n"
            "  translation:\n"
            "    x: 0.1\n"
            "    y: 0\n"
            "    z: 0\n"
            "- parent_frame_id: \"\"\n"
            "  child_frame_id: \"\"\n");
  EXPECT_EQ(
      JsonOf(transforms),
      R"({"transforms":[{"timestamp":"2023-11-14T22:13:20.25Z","parent_frame_id":"map","child_frame_id":"base 1",)"
      R"("translation":{"x":0.1,"y":0,"z":0}},{"parent_frame_id":"","child_frame_id":""}]})");
}

TEST(MessageText, JsonHasNoControlCharacters) {
  Json json;
  json.Value("a\x1b\x7f\xc2\x9b\xe2\x80\xae\n");
  EXPECT_EQ(json.text(), R"("a\u001B\u007F\u009B\u202E\n")");
}

TEST(MessageText, QuotesTextsThatYamlWouldReadAsSomethingElse) {
  foxglove::LaserScan scan;
  for (const char* text : {"true", "Null", "1.5", "-", "a: b", "", "~", "yes", " a"}) {
    scan.set_frame_id(text);
    EXPECT_EQ(YamlOf(scan).substr(0, YamlOf(scan).find('\n')), "frame_id: \"" + std::string(text) + "\"");
  }
}

TEST(MessageText, QuotesNamesOfValuesThatYamlReadsAsBooleans) {
  EXPECT_EQ(NameText("OFF"), "\"OFF\"");
  EXPECT_EQ(NameText("OFFLINE"), "OFFLINE");
}

TEST(MessageText, WritesNumbersThatJsonDoesNotHave) {
  foxglove::LaserScan scan;
  scan.add_ranges(std::numeric_limits<double>::quiet_NaN());
  scan.add_ranges(-std::numeric_limits<double>::infinity());
  EXPECT_NE(YamlOf(scan).find("ranges: [.nan, -.inf]\n"), std::string::npos);
  EXPECT_NE(JsonOf(scan).find(R"("ranges":["NaN","-Infinity"])"), std::string::npos);
}

TEST(MessageText, ShortensBytes) {
  foxglove::RawImage image;
  image.set_data(std::string(1000, '\1'));
  EXPECT_NE(YamlOf(image).find("  # 50 of 1000 bytes\n"), std::string::npos);
  EXPECT_EQ(YamlOf(image, TextLimits::None()).find('#'), std::string::npos);
}

TEST(MessageText, ReadsBase64ThatItWrote) {
  for (std::size_t size = 0; size < 20; ++size) {
    std::string bytes;
    for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(i * 37 + 200);
    std::string read;
    EXPECT_TRUE(FromBase64(Base64(bytes), read));
    EXPECT_EQ(read, bytes);
  }
  std::string none;
  EXPECT_FALSE(FromBase64("a", none));
  EXPECT_FALSE(FromBase64("ab*=", none));
}

TEST(KnownTypes, ReadTheTimesThatTheyWrite) {
  for (const auto& [seconds, nanos] : {std::pair{0L, 0}, {1700000000L, 1}, {-1L, 999999999}, {253402300799L, 5}}) {
    const auto time = ReadKnown(KnownType::kTimestamp, TimestampText(seconds, nanos));
    ASSERT_TRUE(time) << TimestampText(seconds, nanos);
    EXPECT_EQ(time->seconds, seconds);
    EXPECT_EQ(time->nanos, nanos);
  }
  for (const auto& [seconds, nanos] : {std::pair{0L, 0}, {-1L, -500000000}, {0L, -1}, {7L, 250000000}}) {
    const auto time = ReadKnown(KnownType::kDuration, DurationText(seconds, std::int64_t{nanos}));
    ASSERT_TRUE(time) << DurationText(seconds, std::int64_t{nanos});
    EXPECT_EQ(time->seconds, seconds);
    EXPECT_EQ(time->nanos, nanos);
  }
  EXPECT_FALSE(ReadKnown(KnownType::kTimestamp, "tomorrow"));
  EXPECT_FALSE(ReadKnown(KnownType::kDuration, "1.x"));
  EXPECT_TRUE(ReadKnown(KnownType::kTimestamp, "now"));
}

}  // namespace
}  // namespace hgros::cli

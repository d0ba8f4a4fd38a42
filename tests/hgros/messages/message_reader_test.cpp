#include "messages/message_reader.hpp"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include <foxglove/LaserScan.pb.h>
#include <foxglove/Log.pb.h>
#include <foxglove/PointCloud.pb.h>
#include <foxglove/PoseInFrame.pb.h>
#include <foxglove/SceneUpdate.pb.h>
#include <hgros/Snapshot.pb.h>

#include "hgros/messages/all_kinds.hpp"
#include "messages/message_text.hpp"
#include "support/error_of.hpp"

namespace hgros::cli {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using testing::HasSubstr;
using testing::StartsWith;

// The fault, or empty.
std::string FaultOf(const std::string& text, const google::protobuf::Descriptor& type) {
  const auto schema = Dynamic(type);
  const auto message = schema->Read({});
  return test::ErrorOf([&] { ReadMessage(MessageDocument::Parse(text, "message"), *message); });
}
template <class T>
std::string FaultOf(const std::string& text) {
  return FaultOf(text, *T::descriptor());
}
template <class T>
T Read(const std::string& text) {
  T message;
  ReadMessage(MessageDocument::Parse(text, "message"), message);
  return message;
}

// Fills messages with values at and between the limits of their types.
class RandomMessages {
 public:
  explicit RandomMessages(std::uint32_t seed) : random_(seed) {}

  void Fill(Message& message, int depth = 0) {
    const google::protobuf::Descriptor& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
      const FieldDescriptor& field = *type.field(i);
      if (field.message_type() != nullptr && depth > 4) continue;
      const int count = field.is_repeated() ? Below(4) : Below(3) > 0 ? 1 : 0;
      for (int k = 0; k < count; ++k) Set(message, field, depth);
    }
  }
  int Below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(random_); }
  std::string Text() {
    static const std::vector<std::string> kPieces = {
        "a",    "Z",      "7",      " ", "\n", "\t",         "\x1b",   "\"", "\\",     "'", ": ", "#", "-",  "{",
        "true", "\u0085", "\u2028", "ä", "€",  "\U0001F600", "\uFEFF", "[",  "\u202E", "&", "*",  "%", "\r", "~"};
    std::string text;
    for (int i = Below(6); i > 0; --i)
      text += kPieces[static_cast<std::size_t>(Below(static_cast<int>(kPieces.size())))];
    return text;
  }
  std::string Bytes() {
    std::string bytes;
    for (int i = Below(12); i > 0; --i) bytes += static_cast<char>(Below(256));
    return bytes;
  }

 private:
  template <class T>
  T Whole() {
    switch (Below(4)) {
      case 0: return std::numeric_limits<T>::min();
      case 1: return std::numeric_limits<T>::max();
      case 2: return static_cast<T>(Below(1000));
      default: return static_cast<T>(std::uniform_int_distribution<std::uint64_t>()(random_));
    }
  }
  template <class T>
  T Real() {
    switch (Below(8)) {
      case 0: return std::numeric_limits<T>::quiet_NaN();
      case 1: return -std::numeric_limits<T>::infinity();
      case 2: return std::numeric_limits<T>::max();
      case 3: return std::numeric_limits<T>::denorm_min();
      case 4: return T{-0.0};
      default: return static_cast<T>(std::uniform_real_distribution<double>(-1e6, 1e6)(random_));
    }
  }
  void Set(Message& message, const FieldDescriptor& field, int depth) {
    const google::protobuf::Reflection& r = *message.GetReflection();
    const bool add = field.is_repeated();
    switch (field.cpp_type()) {
      case FieldDescriptor::CPPTYPE_BOOL:
        return add ? r.AddBool(&message, &field, Below(2) > 0) : r.SetBool(&message, &field, Below(2) > 0);
      case FieldDescriptor::CPPTYPE_INT32:
        return add ? r.AddInt32(&message, &field, Whole<std::int32_t>())
                   : r.SetInt32(&message, &field, Whole<std::int32_t>());
      case FieldDescriptor::CPPTYPE_INT64:
        return add ? r.AddInt64(&message, &field, Whole<std::int64_t>())
                   : r.SetInt64(&message, &field, Whole<std::int64_t>());
      case FieldDescriptor::CPPTYPE_UINT32:
        return add ? r.AddUInt32(&message, &field, Whole<std::uint32_t>())
                   : r.SetUInt32(&message, &field, Whole<std::uint32_t>());
      case FieldDescriptor::CPPTYPE_UINT64:
        return add ? r.AddUInt64(&message, &field, Whole<std::uint64_t>())
                   : r.SetUInt64(&message, &field, Whole<std::uint64_t>());
      case FieldDescriptor::CPPTYPE_FLOAT:
        return add ? r.AddFloat(&message, &field, Real<float>()) : r.SetFloat(&message, &field, Real<float>());
      case FieldDescriptor::CPPTYPE_DOUBLE:
        return add ? r.AddDouble(&message, &field, Real<double>()) : r.SetDouble(&message, &field, Real<double>());
      case FieldDescriptor::CPPTYPE_ENUM: {
        const int value = Below(3) == 0 ? 1000 + Below(9)
                                        : field.enum_type()->value(Below(field.enum_type()->value_count()))->number();
        return add ? r.AddEnumValue(&message, &field, value) : r.SetEnumValue(&message, &field, value);
      }
      case FieldDescriptor::CPPTYPE_STRING: {
        std::string value = field.type() == FieldDescriptor::TYPE_BYTES ? Bytes() : Text();
        return add ? r.AddString(&message, &field, std::move(value)) : r.SetString(&message, &field, std::move(value));
      }
      case FieldDescriptor::CPPTYPE_MESSAGE:
        Fill(add ? *r.AddMessage(&message, &field) : *r.MutableMessage(&message, &field), depth + 1);
    }
  }

  std::mt19937 random_;
};

class EachType : public testing::TestWithParam<int> {
 protected:
  [[nodiscard]] std::vector<const google::protobuf::Descriptor*> Types() const {
    return {kinds_.finder.Find("kinds.All"),
            foxglove::Log::descriptor(),
            foxglove::LaserScan::descriptor(),
            foxglove::PointCloud::descriptor(),
            foxglove::SceneUpdate::descriptor(),
            foxglove::PoseInFrame::descriptor(),
            Snapshot::descriptor()};
  }

  const AllKinds kinds_{};
};

TEST_P(EachType, ReadsBackWhatEchoWrites) {
  RandomMessages random(static_cast<std::uint32_t>(GetParam()));
  for (const google::protobuf::Descriptor* type : Types()) {
    const auto schema = Dynamic(*type);
    for (int turn = 0; turn < 20; ++turn) {
      const auto written = schema->Read({});
      random.Fill(*written);
      std::string yaml;
      AppendYaml(yaml, {written.get(), nullptr, -1}, TextLimits::None());
      const auto from_yaml = schema->Read({});
      ASSERT_NO_THROW(ReadMessage(MessageDocument::Parse(yaml, "yaml"), *from_yaml)) << "seed " << GetParam() << "\n"
                                                                                     << yaml;
      ASSERT_EQ(from_yaml->SerializePartialAsString(), written->SerializePartialAsString())
          << "seed " << GetParam() << "\n"
          << yaml << "\n"
          << from_yaml->DebugString() << "\n"
          << written->DebugString();

      Json json;
      WriteJson(json, {written.get(), nullptr, -1});
      const std::string text(json.text());
      const auto from_json = schema->Read({});
      ASSERT_NO_THROW(ReadMessage(MessageDocument::ParseJson(text, "json", 1), *from_json)) << text;
      ASSERT_EQ(from_json->SerializePartialAsString(), written->SerializePartialAsString())
          << "seed " << GetParam() << "\n"
          << text;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Seeds, EachType, testing::Range(1, 6));

TEST_P(EachType, NeverFailsOtherwiseThanWithAConfigError) {
  RandomMessages random(static_cast<std::uint32_t>(GetParam()) + 1000);
  int read = 0;
  int refused = 0;
  for (const google::protobuf::Descriptor* type : Types()) {
    const auto schema = Dynamic(*type);
    for (int turn = 0; turn < 150; ++turn) {
      const auto message = schema->Read({});
      random.Fill(*message);
      std::string text;
      if (random.Below(2) == 0) {
        AppendYaml(text, {message.get(), nullptr, -1}, TextLimits::None());
      } else {
        Json json;
        WriteJson(json, {message.get(), nullptr, -1});
        text = json.text();
      }
      if (random.Below(10) == 0) text = random.Bytes() + random.Text();
      for (int change = random.Below(4); change > 0 && !text.empty(); --change) {
        const auto at = static_cast<std::size_t>(random.Below(static_cast<int>(text.size())));
        switch (random.Below(4)) {
          case 0: text[at] = static_cast<char>(random.Below(256)); break;
          case 1: text.erase(at, static_cast<std::size_t>(random.Below(10))); break;
          case 2: text.insert(at, random.Text()); break;
          default: text.insert(at, text.substr(at / 2, 20)); break;
        }
      }
      const auto again = schema->Read({});
      try {
        ReadMessage(MessageDocument::Parse(text, "message"), *again);
        ++read;
      } catch (const ConfigError& error) {
        EXPECT_THAT(error.what(), StartsWith("message")) << text;
        ++refused;
      }
    }
  }
  EXPECT_GT(read, 50);
  EXPECT_GT(refused, 50);
}

TEST(MessageReader, RefusesHalfOfASurrogatePair) {
  EXPECT_EQ(Read<foxglove::Log>(R"({"message": "\ud83d\ude00"})").message(), "\xf0\x9f\x98\x80");
  for (const char* half : {"\\ude00", "\\ud83d", "\\ud83da"}) {
    EXPECT_NE(FaultOf<foxglove::Log>("{\"message\": \"" + std::string(half) + "\"}"), "") << half;
    const std::string key = "{\"" + std::string(half) + "\": 1}";
    EXPECT_THROW((void)MessageDocument::ParseJson(key, "message", 1), ConfigError) << half;
  }
}

TEST(MessageReader, NamesTheNearestFieldWithItsPlace) {
  EXPECT_EQ(FaultOf<foxglove::Log>("{mesage: hello}"),
            "message:1:2: foxglove.Log has no field \"mesage\". Did you mean message?");
  EXPECT_THAT(FaultOf<foxglove::PoseInFrame>("pose:\n  position:\n    xx: 1"),
              StartsWith("message:3:5: foxglove.Vector3 has no field \"xx\"."));
  EXPECT_THAT(FaultOf<foxglove::PoseInFrame>(R"({"pose":{"position":{"q":1}}})"), StartsWith("message:1:22: "));
  EXPECT_THAT(FaultOf<foxglove::PoseInFrame>("{\n \"pose\": [1]}"), StartsWith("message:2:10: "));
  EXPECT_THAT(FaultOf<foxglove::PoseInFrame>(R"({"frame_id": {}})"), StartsWith("message:1:14: "));
  EXPECT_THAT(FaultOf<foxglove::PoseInFrame>(R"({"frame_id": "\"\\", "pose": -12})"), StartsWith("message:1:30: "));
  EXPECT_THAT(FaultOf<foxglove::PoseInFrame>(R"({"pose": "\"\\\" "})"), StartsWith("message:1:10: "));
  EXPECT_THAT(FaultOf<foxglove::PoseInFrame>(R"({"pose": false})"), StartsWith("message:1:10: "));
}

TEST(MessageReader, RefusesValuesOfAnotherKind) {
  EXPECT_EQ(FaultOf<foxglove::Log>("line: ten"), "message:1:7: line must be a whole number, and not \"ten\".");
  EXPECT_EQ(FaultOf<foxglove::Log>("line: '1'"), "message:1:7: line must be a whole number, and not \"1\" in quotes.");
  EXPECT_EQ(FaultOf<foxglove::Log>("line: 1.5"), "message:1:7: line must be a whole number, and not \"1.5\".");
  EXPECT_EQ(FaultOf<foxglove::Log>("message: [a]"), "message:1:10: message must be a text, and not a list.");
  EXPECT_EQ(FaultOf<foxglove::LaserScan>("ranges: 1"),
            "message:1:9: ranges is a list. Write its items in brackets: [..., ...].");
  EXPECT_EQ(FaultOf<foxglove::LaserScan>("ranges: [1, x]"), "message:1:13: ranges must be a number, and not \"x\".");
  EXPECT_EQ(FaultOf<foxglove::LaserScan>("pose: 1"),
            "message:1:7: pose must be a map of the fields of foxglove.Pose, and not \"1\".");
  EXPECT_EQ(FaultOf<foxglove::PointCloud>("data: '*'"), "message:1:7: data must be base64, and not \"*\" in quotes.");
  EXPECT_THAT(FaultOf<foxglove::Log>("timestamp: tomorrow"), HasSubstr("timestamp must be a time such as"));
  EXPECT_THAT(FaultOf<foxglove::Log>("[1]"), HasSubstr("A message of foxglove.Log is a map of its fields."));
}

TEST(MessageReader, RefusesNumbersOutOfRange) {
  EXPECT_THAT(FaultOf<foxglove::Log>("line: 4294967296"),
              HasSubstr("is out of range for line, which is uint32 and goes from 0 to 4294967295."));
  EXPECT_THAT(FaultOf<foxglove::Log>("line: -1"), HasSubstr("out of range for line"));
  EXPECT_EQ(FaultOf<foxglove::Log>("line: 0xFF"), "");
  EXPECT_THAT(FaultOf<foxglove::LaserScan>("start_angle: 1e400"), HasSubstr("is too large for start_angle"));
  EXPECT_EQ(FaultOf<foxglove::LaserScan>("start_angle: 1e-400"), "");
  const AllKinds kinds;
  const google::protobuf::Descriptor& all = kinds.finder.Require("kinds.All");
  EXPECT_THAT(FaultOf("a_float: 3.5e38", all), HasSubstr("is too large for a_float, which is a float."));
  EXPECT_THAT(FaultOf("a_float: -3.5e38", all), HasSubstr("is too large for a_float, which is a float."));
  EXPECT_EQ(FaultOf("a_float: 1e-60", all), "");
  for (const char* text : {"a_int32: 2147483648", "a_int32: -2147483649", "a_int64: 9223372036854775808",
                           "a_uint64: 18446744073709551616", "a_uint64: -1", "a_sint64: -9223372036854775809"}) {
    EXPECT_THAT(FaultOf(text, all), HasSubstr("is out of range for a_")) << text;
  }
  for (const char* text : {"a_int32: 1e3", "a_int32: +-1", "a_int32: 0x", "a_int32: true", "a_double: 1.2.3",
                           "a_double: 0x10", "a_double: --1", "a_double: '1'", "a_bool: yes", "a_bool: 1"}) {
    EXPECT_THAT(FaultOf(text, all), HasSubstr(" must be ")) << text;
  }
}

TEST(MessageReader, ReadsEnumsByNameAndNumberAndNamesTheNearest) {
  EXPECT_EQ(Read<foxglove::Log>("level: WARNING").level(), foxglove::Log::WARNING);
  EXPECT_EQ(Read<foxglove::Log>("level: 4").level(), foxglove::Log::ERROR);
  EXPECT_EQ(FaultOf<foxglove::Log>("level: warnin"),
            "message:1:8: \"warnin\" is not a value of foxglove.Log.Level. Did you mean WARNING?");
  EXPECT_THAT(FaultOf<foxglove::Log>("level: Purple"),
              HasSubstr("It has: UNKNOWN, DEBUG, INFO, WARNING, ERROR, FATAL."));
}

TEST(MessageReader, ReadsTimesAsTextSecondsFieldsAndNow) {
  EXPECT_EQ(Read<foxglove::Log>("timestamp: 2026-11-23T11:50:33.25Z").timestamp().nanos(), 250000000);
  EXPECT_EQ(Read<foxglove::Log>("timestamp: 5.5").timestamp().seconds(), 5);
  const foxglove::Log before_1970 = Read<foxglove::Log>("timestamp: -0.5");
  EXPECT_EQ(before_1970.timestamp().seconds(), -1);
  EXPECT_EQ(before_1970.timestamp().nanos(), 500000000);
  EXPECT_EQ(Read<foxglove::Log>("timestamp: {seconds: 7, nanos: 8}").timestamp().nanos(), 8);
  EXPECT_GT(Read<foxglove::Log>("timestamp: now").timestamp().seconds(), 1700000000);
}

TEST(MessageReader, ReadsMapsInBothForms) {
  const AllKinds kinds;
  const auto schema = Dynamic(kinds.finder.Require("kinds.All"));
  const auto short_form = schema->Read({});
  const auto long_form = schema->Read({});
  ReadMessage(MessageDocument::Parse("labels: {a: 1, b: -2}", "one"), *short_form);
  ReadMessage(MessageDocument::Parse("labels: [{key: a, value: 1}, {key: b, value: -2}]", "other"), *long_form);
  EXPECT_EQ(short_form->SerializeAsString(), long_form->SerializeAsString());
  EXPECT_NE(short_form->SerializeAsString(), "");
  EXPECT_EQ(FaultOf("{\"parts\": {\"7\": {\"x\": 1}}}", schema->descriptor()), "");
  EXPECT_THAT(FaultOf("parts: {seven: {x: 1}}", schema->descriptor()), HasSubstr("key must be a whole number"));
  EXPECT_THAT(FaultOf("chosen_number: 1\nchosen_text: b", schema->descriptor()),
              HasSubstr("message:2:1: Only one field of choice can be set, and chosen_text is the second."));
}

TEST(MessageReader, ReadsJsonWithCharactersOfTwoEscapesAndLongNumbersInQuotes) {
  EXPECT_EQ(Read<foxglove::Log>(R"({"message":"\uD83D\uDE00 \/"})").message(), "\U0001F600 /");
  EXPECT_EQ(Read<foxglove::Log>(R"({"timestamp":{"seconds":"12"}})").timestamp().seconds(), 12);
  EXPECT_THAT(FaultOf<foxglove::Log>(R"({"message":"a","message":"b"})"),
              HasSubstr("message:1:16: The field message is given twice."));
}

TEST(MessageReader, RefusesDeepAndHugeTexts) {
  EXPECT_THAT(FaultOf<foxglove::Log>(std::string(100, '[') + std::string(100, ']')),
              HasSubstr("nested more than 64 deep"));
  EXPECT_THAT(FaultOf<foxglove::Log>(std::string(100'000, '[')), StartsWith("message:1:1: "));
  std::string json;
  for (int i = 0; i < 100'000; ++i) json += "{\"a\":";
  EXPECT_THAT(FaultOf<foxglove::Log>(json), StartsWith("message"));
  EXPECT_THROW((void)MessageDocument::ParseJson(json, "line", 1), ConfigError);
  EXPECT_THAT(FaultOf<foxglove::Log>("message: " + std::string(2'000'000, 'a')), HasSubstr("1 MiB"));
  const std::string many = "{\"ranges\":[" + [] {
    std::string items = "0";
    for (int i = 0; i < 1'000'100; ++i) items += ",0";
    return items;
  }() + "]}";
  EXPECT_THAT([&] { (void)MessageDocument::ParseJson(many, "line", 1); },
              testing::ThrowsMessage<ConfigError>(HasSubstr("There are more than 1000000 values.")));
}

TEST(MessageDocument, TellsTheLineAndColumnOfAJsonFault) {
  EXPECT_THAT([] { (void)MessageDocument::ParseJson("{\"a\": nul}", "x.jsonl", 12); },
              testing::ThrowsMessage<ConfigError>(StartsWith("x.jsonl:12:")));
}

}  // namespace
}  // namespace hgros::cli

// Services whose two sides were built with different versions of a schema, and services with bulk replies.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>
#include <google/protobuf/text_format.h>

#include <cstdint>
#include <cstring>

#include <foxglove/PointCloud.pb.h>

#include "services/services_fixture.hpp"

namespace hgros::test {

enum class Version {
  kOld,
  kNew,    // Has an additional number.
  kOther,  // Has a number in place of the text.
};

/// The class in a program that was built with one version of `robot.Line`.
template <Version kVersion>
struct Line {
  std::string text;
  std::int32_t number = 0;
};

/// The schema of one version. It has its own pool, because a pool cannot hold two types of one name.
template <Version kVersion>
struct LineSchema {
  static const google::protobuf::Descriptor* descriptor() {
    static const google::protobuf::DescriptorPool* const pool = [] {
      google::protobuf::FileDescriptorProto file;
      const std::string type = kVersion == Version::kOther ? "TYPE_INT64" : "TYPE_STRING";
      std::string fields = "field { name: 'text' number: 1 label: LABEL_OPTIONAL type: " + type + " } ";
      if (kVersion == Version::kNew)
        fields += "field { name: 'number' number: 2 label: LABEL_OPTIONAL type: TYPE_INT32 }";
      EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(
          "name: 'line.proto' package: 'robot' syntax: 'proto3' message_type { name: 'Line' " + fields + " }", &file));
      auto* made = new google::protobuf::DescriptorPool();  // Never destroyed.
      EXPECT_NE(made->BuildFile(file), nullptr);
      return made;
    }();
    return pool->FindMessageTypeByName("robot.Line");
  }
  static std::unique_ptr<google::protobuf::Message> Make() {
    static auto* const factory = new google::protobuf::DynamicMessageFactory();
    return std::unique_ptr<google::protobuf::Message>(factory->GetPrototype(descriptor())->New());
  }
};

}  // namespace hgros::test

template <hgros::test::Version kVersion>
struct hgros::CustomCodec<hgros::test::Line<kVersion>> {
  using Schema = hgros::test::LineSchema<kVersion>;
  using Line = hgros::test::Line<kVersion>;

  static bool Serialize(const Line& line, std::string& bytes) {
    const auto message = Schema::Make();
    const auto& fields = *Schema::descriptor();
    const auto& access = *message->GetReflection();
    if constexpr (kVersion == hgros::test::Version::kOther) {
      access.SetInt64(message.get(), fields.field(0), line.number);
    } else {
      access.SetString(message.get(), fields.field(0), line.text);
    }
    if (fields.field_count() > 1) access.SetInt32(message.get(), fields.field(1), line.number);
    return message->SerializeToString(&bytes);
  }
  static bool Parse(std::string_view bytes, Line& line) {
    const auto message = Schema::Make();
    if (!message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return false;
    const auto& fields = *Schema::descriptor();
    const auto& access = *message->GetReflection();
    if constexpr (kVersion != hgros::test::Version::kOther) line.text = access.GetString(*message, fields.field(0));
    if (fields.field_count() > 1) line.number = access.GetInt32(*message, fields.field(1));
    return true;
  }
};

namespace hgros {
namespace {

using foxglove::PointCloud;
using test::Kind;
using test::kLong;
using test::Sum;
using OldLine = test::Line<test::Version::kOld>;
using NewLine = test::Line<test::Version::kNew>;
using OtherLine = test::Line<test::Version::kOther>;
using BulkCloud = Bulk<PointCloud>;

template <class Line>
Line Twice(const Line& line) {
  return {line.text + line.text, line.number + 1};
}

constexpr std::size_t kSize = 300'000;

std::unique_ptr<BulkCloud> CloudOf(const Sum& sum) {
  auto cloud = std::make_unique<BulkCloud>(kSize);
  cloud->head().set_frame_id("lidar");
  std::memset(cloud->writable().data(), sum.a, kSize);
  return cloud;
}

// Between two sessions, because inside one session both sides use the same C++ type.
class ServiceBetweenSessions : public test::PairFixture {};

TEST_P(ServiceBetweenSessions, ClientsAndServersOfTheOldAndTheNewVersionCanCallEachOther) {
  std::atomic<int> number{-1};
  const Service new_server = pair->server().Serve<NewLine, NewLine>("new", [&](const NewLine& line) {
    number = line.number;
    return Twice(line);
  });
  for (int i = 0; i < 3; ++i) {
    const auto result = pair->caller().Call<OldLine, OldLine>("new", OldLine{"ab", 7}, kLong).Wait();
    ASSERT_TRUE(result) << result.failure().reason;
    EXPECT_EQ(result->text, "abab");
    EXPECT_EQ(result->number, 0) << "it does not know that field";
    EXPECT_EQ(number, 0) << "the client did not send it";
  }
  const Service old_server = pair->server().Serve<OldLine, OldLine>("old", Twice<OldLine>);
  const auto result = pair->caller().Call<NewLine, NewLine>("old", NewLine{"ab", 7}, kLong).Wait();
  ASSERT_TRUE(result) << result.failure().reason;
  EXPECT_EQ(result->text, "abab");
  EXPECT_EQ(result->number, 0) << "the server did not send it";
}

TEST_P(ServiceBetweenSessions, RefusesARequestOrAReplyWithAnIncompatibleFieldAndNamesIt) {
  std::atomic<int> handled{0};
  const Service request = pair->server().Serve<OtherLine, OldLine>("request", [&](const OtherLine&) {
    ++handled;
    return OldLine();
  });
  const Service reply = pair->server().Serve<OldLine, OtherLine>("reply", [](const OldLine&) { return OtherLine(); });
  for (const char* service : {"request", "reply"}) {
    const auto result = pair->caller().Call<OldLine, OldLine>(service, OldLine{"ab"}, kLong).Wait();
    EXPECT_EQ(result.failure().kind, Kind::kTypeMismatch) << result.failure().reason;
    EXPECT_NE(result.failure().reason.find("text"), std::string::npos) << result.failure().reason;
  }
  EXPECT_EQ(handled, 0);
}

TEST_P(ServiceBetweenSessions, BulkReplyArrivesAsABulkMessageOrAsAPlainOneForAPlainCaller) {
  const Service service = pair->server().Serve<Sum, BulkCloud>("cloud", CloudOf);
  for (const char value : {'a', 'b'}) {
    const auto bulk = pair->caller().Call<Sum, BulkCloud>("cloud", Sum{value, 0}, kLong).Wait();
    ASSERT_TRUE(bulk) << bulk.failure().reason;
    EXPECT_EQ(bulk->head().frame_id(), "lidar");
    EXPECT_TRUE(AsText(bulk->bytes()) == std::string(kSize, value));
  }
  const Service plainly = pair->server().Serve<Sum, BulkCloud>("plainly", CloudOf);
  const auto plain = pair->caller().Call<Sum, PointCloud>("plainly", Sum{'c', 0}, kLong).Wait();
  ASSERT_TRUE(plain) << plain.failure().reason;
  EXPECT_EQ(plain->frame_id(), "lidar");
  EXPECT_TRUE(plain->data() == std::string(kSize, 'c'));
}

TEST(ServiceInOneSession, PassesABulkReplyByPointer) {
  Session session;
  std::shared_ptr<const BulkCloud> given;
  const Service service = session.Serve<Sum, BulkCloud>("cloud", [&](const Sum& sum) {
    given = CloudOf(sum);
    return given;
  });
  const auto result = session.Call<Sum, BulkCloud>("cloud", Sum{'a', 0}, kLong).Wait();
  ASSERT_TRUE(result) << result.failure().reason;
  EXPECT_EQ(&*result, given.get());
}

INSTANTIATE_TEST_SUITE_P(Placed, ServiceBetweenSessions, testing::Values("sharedmemory", "ipc", "tcp"),
                         test::TransportName);

}  // namespace
}  // namespace hgros

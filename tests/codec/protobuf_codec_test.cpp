#include "hgros/internal/codec/protobuf_codec.hpp"

#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include "foxglove/Log.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "hgros/BatteryState.pb.h"
#include "hgros/Diagnostics.pb.h"
#include "hgros/Imu.pb.h"
#include "hgros/Twist.pb.h"
#include "hgros/codec/message.hpp"
#include "hgros/codec/protobuf_log.hpp"

namespace hgros::protobuf_codec_test {
namespace {

std::shared_ptr<const foxglove::PointCloud> Cloud() {
  auto cloud = std::make_shared<foxglove::PointCloud>();
  cloud->set_frame_id("lidar");
  cloud->set_point_stride(16);
  auto* const field = cloud->add_fields();
  field->set_name("x");
  field->set_type(foxglove::PackedElementField::FLOAT32);
  cloud->set_data(std::string(16'000, 'p'));
  return cloud;
}

TEST(ProtobufCodec, ReadsBackWhatWasSentAndCountsItsMemory) {
  const auto cloud = Cloud();
  const TypeInfo& info = TypeOf<foxglove::PointCloud>();
  const Payload payload = info.encode(cloud);
  ASSERT_TRUE(payload.owner);
  EXPECT_EQ(AsText(payload.bytes), cloud->SerializeAsString());
  const auto back = std::static_pointer_cast<const foxglove::PointCloud>(info.decode(payload));
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(back->SerializeAsString(), cloud->SerializeAsString());
  EXPECT_GE(info.memory_bytes(cloud.get()), 16'000U);
}

TEST(ProtobufCodec, WritesAnEmptyMessageAsNoBytes) {
  const Payload payload = TypeOf<Imu>().encode(std::make_shared<const Imu>());
  EXPECT_TRUE(payload.owner);
  EXPECT_TRUE(payload.bytes.empty());
  EXPECT_NE(TypeOf<Imu>().decode(payload), nullptr);
}

TEST(ProtobufCodec, RefusesBytesOfAnotherMessage) {
  const TypeInfo& info = TypeOf<foxglove::PointCloud>();
  const Payload payload = info.encode(Cloud());
  EXPECT_EQ(info.decode({payload.bytes.first(payload.bytes.size() - 1), payload.owner}), nullptr);
  EXPECT_EQ(info.decode({AsBytes("\xff\xff\xff"), nullptr}), nullptr);
}

TEST(ProtobufCodec, RefusesAMessageWithoutARequiredField) {
  google::protobuf::UninterpretedOption option;
  option.add_name()->set_name_part("x");  // NamePart.is_extension is required.
  const TypeInfo& info = TypeOf<google::protobuf::UninterpretedOption>();
  const std::string bytes = option.SerializePartialAsString();
  EXPECT_FALSE(info.encode(std::make_shared<const google::protobuf::UninterpretedOption>(option)).owner);
  EXPECT_EQ(info.decode({AsBytes(bytes), nullptr}), nullptr);
}

TEST(ProtobufCodec, HasNameAndSchema) {
  const TypeInfo& info = TypeOf<Imu>();
  EXPECT_EQ(info.name, "hgros.Imu");
  EXPECT_EQ(info.encoding, Encoding::kProtobuf);
  EXPECT_EQ(info.descriptor(), Imu::descriptor());
  EXPECT_EQ(info.fingerprint, SchemaFingerprint(*Imu::descriptor()));
  EXPECT_EQ(info.descriptor_set(), DescriptorSet(*Imu::descriptor()));
}

TEST(ProtobufCodec, KnowsVelocitiesBatteriesAndDiagnostics) {
  EXPECT_EQ(TypeOf<Twist>().name, "hgros.Twist");
  const TypeInfo& batteries = TypeOf<BatteryState>();
  auto battery = std::make_shared<BatteryState>();
  battery->set_current(0);
  const auto read = std::static_pointer_cast<const BatteryState>(batteries.decode(batteries.encode(battery)));
  ASSERT_NE(read, nullptr);
  EXPECT_TRUE(read->has_current());
  EXPECT_FALSE(read->has_voltage()) << "unknown, not 0";
  EXPECT_EQ(TypeOf<Diagnostics>().name, "hgros.Diagnostics");
  EXPECT_EQ(Diagnostics::STALE, 3);
}

int said = 0;
void Count(google::protobuf::LogLevel, const char*, int, const std::string&) { ++said; }

TEST(ProtobufLog, DoesNotRepeatThatTextsAreNotUtf8) {
  google::protobuf::LogHandler* const before = google::protobuf::SetLogHandler(Count);
  LimitProtobufLog();
  LimitProtobufLog();
  for (int i = 0; i < 100; ++i) {
    foxglove::Log log;
    EXPECT_FALSE(log.ParseFromString("\x1a\x01\xff"));  // Field 3, a text of one byte.
  }
  EXPECT_EQ(said, 1);
  google::protobuf::SetLogHandler(before);
}

}  // namespace
}  // namespace hgros::protobuf_codec_test

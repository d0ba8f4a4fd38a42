#include "hgros/codec/run_time_type.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include <foxglove/Vector2.pb.h>
#include <foxglove/Vector3.pb.h>

#include "hgros/base/error.hpp"
#include "hgros/codec/message.hpp"
#include "hgros/codec/schema_match.hpp"

namespace hgros {
namespace {

using foxglove::Vector3;

MessageSchema SchemaOfVector() { return SchemaOf(TypeOf<Vector3>()); }

TEST(RunTimeType, IsOneObjectForEachSchema) {
  MessageSchema without_fingerprint = SchemaOfVector();
  without_fingerprint.fingerprint = 0;
  EXPECT_EQ(&RunTimeType(SchemaOfVector()), &RunTimeType(SchemaOfVector()));
  EXPECT_EQ(&RunTimeType(without_fingerprint), &RunTimeType(SchemaOfVector()));
  EXPECT_NE(&RunTimeType({"json", Encoding::kCustom, 0, {}}), &RunTimeType({"text", Encoding::kCustom, 0, {}}));
}

TEST(RunTimeType, ComputesTheFingerprintFromTheDescriptorSet) {
  MessageSchema wrong = SchemaOfVector();
  wrong.fingerprint = 42;
  EXPECT_EQ(RunTimeType(wrong).fingerprint, TypeOf<Vector3>().fingerprint);
  EXPECT_EQ(SchemaOf(RunTimeType(wrong)), SchemaOfVector());
  ASSERT_NE(DescriptorOf(RunTimeType(wrong)), nullptr);
}

TEST(RunTimeType, RefusesSchemasWithoutTypeOrWithBrokenDescriptors) {
  EXPECT_THROW((void)RunTimeType({}), Error);
  EXPECT_THROW((void)RunTimeType({"a", Encoding::kNone, 0, {}}), Error);
  EXPECT_THROW((void)RunTimeType({"a", Encoding::kProtobuf, 0, "no descriptors"}), Error);
  MessageSchema missing = SchemaOfVector();
  missing.type_name = "robot.Missing";
  EXPECT_THROW((void)RunTimeType(missing), Error);
}

// Named in a process of its own, because types are never forgotten. Returns how many it could name.
std::size_t Named(std::size_t count, const std::string& description) {
  for (std::size_t i = 0; i < count; ++i) {
    try {
      (void)RunTimeType({"type" + std::to_string(i), Encoding::kCustom, 0, description});
    } catch (const Error& error) {
      std::fputs(error.what(), stderr);
      (void)RunTimeType({"type0", Encoding::kCustom, 0, description});
      return i;
    }
  }
  return count;
}

TEST(RunTimeType, AreLimitedInNumberAndBytes) {
  EXPECT_EXIT(std::exit(Named(2 * kMostRunTimeTypes, "") <= kMostRunTimeTypes ? 0 : 1), testing::ExitedWithCode(0),
              "is refused: this process has named 4[0-9]+ types at run time");
  EXPECT_EXIT(std::exit(Named(200, std::string(1 << 20, 'x')) < 64 ? 0 : 1), testing::ExitedWithCode(0),
              "descriptions of 6[0-9]+ bytes");
}

TEST(RunTimeType, IsInterchangeableWithTheClassOfItsSchemaOnly) {
  const TypeInfo& raw = RunTimeType(SchemaOfVector());
  EXPECT_TRUE(AreInterchangeable(raw, TypeOf<Vector3>()));
  EXPECT_TRUE(AreInterchangeable(TypeOf<Vector3>(), raw));
  EXPECT_TRUE(AreInterchangeable(RunTimeType({"foxglove.Vector3", Encoding::kProtobuf, 0, {}}), TypeOf<Vector3>()));
  EXPECT_FALSE(AreInterchangeable(RunTimeType({"foxglove.Vector3", Encoding::kProtobuf, 1, {}}), TypeOf<Vector3>()));
  EXPECT_FALSE(AreInterchangeable(RunTimeType({"foxglove.Vector3", Encoding::kCustom, 0, {}}), TypeOf<Vector3>()));
  EXPECT_FALSE(AreInterchangeable(TypeOf<int>(), TypeOf<Vector3>()));
}

TEST(SchemaMatch, ComparesNameAndSchemaAndKnowsTheFingerprint) {
  EXPECT_EQ(MisfitOf(SchemaOfVector(), SchemaOfVector()), "");
  const std::string misfit = MisfitOf(SchemaOf(TypeOf<foxglove::Vector2>()), SchemaOfVector());
  EXPECT_NE(misfit.find("foxglove.Vector2 there and foxglove.Vector3 here"), std::string::npos) << misfit;
  EXPECT_THROW((void)MisfitOf(SchemaOfVector(), MessageSchema{}), Error);
  MessageSchema schema = SchemaOfVector();
  schema.fingerprint = 0;
  EXPECT_EQ(NamedSchema(schema), SchemaOfVector()) << "it has the fingerprint of its descriptor set";
}

TEST(RunTimeType, MessagesAreConvertedBothWaysUnlessTheyDoNotParse) {
  auto vector = std::make_shared<Vector3>();
  vector->set_y(2);
  const TypeInfo& raw_type = RunTimeType(SchemaOfVector());
  const AnyMessage raw = ConvertMessage(std::shared_ptr<const Vector3>(vector), TypeOf<Vector3>(), raw_type);
  ASSERT_NE(raw, nullptr);
  EXPECT_EQ(*static_cast<const RawMessage*>(raw.get())->schema, SchemaOfVector());
  const AnyMessage back = ConvertMessage(raw, raw_type, TypeOf<Vector3>());
  ASSERT_NE(back, nullptr);
  EXPECT_EQ(static_cast<const Vector3*>(back.get())->y(), 2);
  EXPECT_EQ(ConvertMessage(raw, raw_type, AnyType()), raw) << "no copy";
  const AnyMessage broken = raw_type.decode(OwnedPayload({AsBytes("\xff\xff"), nullptr}));
  ASSERT_NE(broken, nullptr);
  EXPECT_EQ(ConvertMessage(broken, raw_type, TypeOf<Vector3>()), nullptr);
}

TEST(RunTimeType, DescriptionDistinguishesTypesOfOneName) {
  EXPECT_EQ(DescribeTypeFully(RunTimeType({"robot.Pair", Encoding::kPlain, 0xabc, {}})),
            "robot.Pair (a plain struct, fingerprint 0000000000000abc)");
  EXPECT_EQ(DescribeTypeFully(RunTimeType({"json", Encoding::kCustom, 0, {}})),
            "json (its own encoding, no fingerprint)");
}

}  // namespace
}  // namespace hgros

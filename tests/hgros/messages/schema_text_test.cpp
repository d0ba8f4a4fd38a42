#include "messages/schema_text.hpp"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <string>

#include <foxglove/FrameTransforms.pb.h>
#include <foxglove/Log.pb.h>
#include <foxglove/SceneUpdate.pb.h>

#include "hgros/messages/all_kinds.hpp"
#include "messages/message_reader.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;

TEST(SchemaText, WritesATypeAfterTheTypesInIt) {
  EXPECT_EQ(ProtoText(*foxglove::Log::descriptor()),
            "// google.protobuf.Timestamp, from google/protobuf/timestamp.proto\n"
            "message Timestamp {\n"
            "  int64 seconds = 1;\n"
            "  int32 nanos = 2;\n"
            "}\n"
            "\n"
            "// foxglove.Log, from foxglove/Log.proto\n"
            "message Log {\n"
            "  enum Level {\n"
            "    UNKNOWN = 0;\n"
            "    DEBUG = 1;\n"
            "    INFO = 2;\n"
            "    WARNING = 3;\n"
            "    ERROR = 4;\n"
            "    FATAL = 5;\n"
            "  }\n"
            "  google.protobuf.Timestamp timestamp = 1;\n"
            "  Level level = 2;\n"
            "  string message = 3;\n"
            "  string name = 4;\n"
            "  string file = 5;\n"
            "  fixed32 line = 6;\n"
            "}\n");
}

TEST(SchemaText, WritesMapsOneofsAndOptionalFieldsOfAPublishersSchema) {
  const AllKinds kinds;
  const auto schema = Dynamic(kinds.finder.Require("kinds.All"));
  const std::string text = ProtoText(schema->descriptor());
  EXPECT_THAT(text, HasSubstr("  map<string, int32> labels = 40;\n  map<uint32, Part> parts = 41;\n"));
  EXPECT_THAT(text, HasSubstr("  oneof choice {\n    int32 chosen_number = 50;\n    string chosen_text = 51;\n"));
  EXPECT_THAT(text, HasSubstr("double maybe = 60;\n  foxglove.Pose pose = 70;\n}\n"));
  EXPECT_THAT(text, HasSubstr("  repeated bytes blocks = 22;\n"));
  EXPECT_THAT(text, HasSubstr("enum Color {\n  RED = 0;\n"));
  EXPECT_THAT(text, testing::Not(HasSubstr("LabelsEntry")));
}

TEST(SchemaText, WritesATemplateThatCanBePublished) {
  const AllKinds kinds;
  for (const char* name : {"kinds.All", "foxglove.SceneUpdate", "foxglove.FrameTransforms", "foxglove.Log",
                           "foxglove.PointCloud", "foxglove.CameraCalibration", "hgros.Snapshot"}) {
    const google::protobuf::Descriptor& type = kinds.finder.Require(name);
    const auto schema = Dynamic(type);
    const auto message = schema->Read({});
    const std::string text = TemplateText(type);
    EXPECT_NO_THROW(ReadMessage(MessageDocument::Parse(text, name), *message)) << text;
    for (int i = 0; i < type.field_count(); ++i) EXPECT_THAT(text, HasSubstr(type.field(i)->name() + ":"));
  }
  EXPECT_EQ(TemplateText(*foxglove::Log::descriptor()),
            "timestamp: now\n"
            "level: UNKNOWN  # or DEBUG, INFO, WARNING, ERROR, FATAL\n"
            "message: \"\"\n"
            "name: \"\"\n"
            "file: \"\"\n"
            "line: 0\n");
}

// Each type has two fields of the next: 2^30 paths.
TEST(SchemaText, BoundsTheTemplateOfATypeWithManyPaths) {
  google::protobuf::FileDescriptorProto file;
  file.set_name("hostile\x1b[31m.proto");
  file.set_package("many");
  for (int i = 0; i < 30; ++i) {
    auto& type = *file.add_message_type();
    type.set_name("T" + std::to_string(i));
    for (int f = 1; f <= 2; ++f) {
      auto& field = *type.add_field();
      field.set_name("f" + std::to_string(f));
      field.set_number(f);
      field.set_label(google::protobuf::FieldDescriptorProto::LABEL_REPEATED);
      field.set_type(google::protobuf::FieldDescriptorProto::TYPE_MESSAGE);
      field.set_type_name(".many.T" + std::to_string((i + 1) % 30));
    }
  }
  google::protobuf::DescriptorPool pool;
  const google::protobuf::FileDescriptor* built = pool.BuildFile(file);
  ASSERT_NE(built, nullptr);
  const std::string text = TemplateText(*built->message_type(0));
  EXPECT_LT(text.size(), 400'000U);
  const auto schema = Dynamic(*built->message_type(0));
  const auto message = schema->Read({});
  EXPECT_NO_THROW(ReadMessage(MessageDocument::Parse(text, "many"), *message));
  EXPECT_THAT(ProtoText(schema->descriptor()), testing::Not(HasSubstr("\x1b")));
}

}  // namespace
}  // namespace hgros::cli

#include "messages/type_finder.hpp"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <string>

#include "hgros/base/error.hpp"
#include "hgros/proto_folder.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;

std::string FaultOfFiles(const TypeOptions& options) {
  try {
    const TypeFinder finder(options);
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

TEST(TypeFinder, FindsTypesOfTheLibraryWithoutFiles) {
  const TypeOptions options;
  const TypeFinder finder(options);
  ASSERT_NE(finder.Find("foxglove.Log"), nullptr);
  EXPECT_EQ(finder.Find("foxglove/Log"), finder.Find("foxglove.Log"));
  EXPECT_EQ(finder.Find("foxglove.Lig"), nullptr);
  EXPECT_THAT(
      [&] { (void)finder.Require("foxglove.LaserScn"); },
      testing::ThrowsMessage<UsageError>("The type foxglove.LaserScn is not known. Did you mean foxglove.LaserScan?"));
  EXPECT_EQ(finder.Nearest("LaserScan"), "foxglove.LaserScan");
}

TEST(TypeFinder, ReadsFilesWithImportsFromFoldersAndTheLibrary) {
  const ProtoFolder folder;
  (void)folder.Write("robot/part.proto", "syntax = \"proto3\"; package robot; message Part { int32 size = 1; }");
  const std::string arm =
      folder.Write("robot/arm.proto",
                   "syntax = \"proto3\"; package robot; import \"robot/part.proto\"; import "
                   "\"foxglove/Pose.proto\"; message Arm { Part part = 1; foxglove.Pose pose = 2; }");
  const TypeOptions options{{arm}, {folder.path()}};
  const TypeFinder finder(options);
  const google::protobuf::Descriptor& type = finder.Require("robot.Arm");
  EXPECT_EQ(type.file()->name(), "robot/arm.proto");
  EXPECT_EQ(SchemaFor(type).type_name, "robot.Arm");
  EXPECT_NE(SchemaFor(type).fingerprint, 0U);
  EXPECT_EQ(finder.Nearest("robot.Armm"), "robot.Arm");
}

TEST(TypeFinder, FindsATypeInTheFileThatIsNamedLikeIt) {
  const ProtoFolder folder;
  (void)folder.Write("robot/Grip.proto", "syntax = \"proto3\"; package robot; message Grip { message Jaw {} }");
  const TypeOptions options{{}, {folder.path()}};
  const TypeFinder finder(options);
  EXPECT_NE(finder.Find("robot.Grip"), nullptr);
  EXPECT_NE(finder.Find("robot.Grip.Jaw"), nullptr);
  EXPECT_EQ(finder.Find("robot.Grop"), nullptr);
}

TEST(TypeFinder, TellsFileLineAndColumnOfAFault) {
  const ProtoFolder folder;
  const std::string broken = folder.Write("broken.proto", "syntax = \"proto3\";\nmessage A {\n  int32 x;\n}\n");
  EXPECT_THAT(FaultOfFiles({{broken}, {}}), HasSubstr(broken + ":3:10: Missing field number."));
  const std::string unknown = folder.Write("unknown.proto", "syntax = \"proto3\";\nmessage A {\n  B b = 1;\n}\n");
  EXPECT_THAT(FaultOfFiles({{unknown}, {}}), HasSubstr(unknown + ":3:3: \"B\" is not defined."));
  const std::string lonely = folder.Write("lonely.proto", "syntax = \"proto3\";\nimport \"no/such.proto\";\n");
  EXPECT_THAT(FaultOfFiles({{lonely}, {}}), HasSubstr("no/such.proto"));
  EXPECT_EQ(FaultOfFiles({{folder.path() + "/none.proto"}, {}}),
            "--proto: there is no file " + folder.path() + "/none.proto.");
  EXPECT_EQ(FaultOfFiles({{"/"}, {}}), "--proto: / is a folder. Name a .proto file, or give the folder with -I.");
  EXPECT_EQ(FaultOfFiles({{}, {folder.path() + "/none"}}), "-I: there is no folder " + folder.path() + "/none.");
}

}  // namespace
}  // namespace hgros::cli

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "hgros/command_run.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using testing::HasSubstr;

TEST(HgrosNew, WritesAPackageOnce) {
  const test::ScratchFolder folder;
  const auto run = [&](const std::string& name) {
    return RunInShell("cd $FOLDER && $HGROS new " + name, {{"FOLDER", folder.path()}});
  };
  EXPECT_THAT(run("arm"), Writes(HasSubstr("  cd arm\n")));
  EXPECT_THAT(folder.Read("arm/CMakeLists.txt"), HasSubstr("COMPONENTS arm/Limiter LINK arm_messages)"));
  EXPECT_THAT(folder.Read("arm/arm.proto"), HasSubstr("package arm_messages;"));
  EXPECT_THAT(folder.Read("arm/limiter.cpp"), HasSubstr("HGROS_COMPONENT(Limiter, \"arm/Limiter\")"));
  EXPECT_THAT(folder.Read("arm/limiter_test.cpp"), HasSubstr("Take<arm_messages::Speed>"));
  EXPECT_THAT(folder.Read("arm/robot.yaml"), HasSubstr("type: arm/Limiter"));
  EXPECT_THAT(run("double"), Writes(HasSubstr("  cd double\n")));
  EXPECT_THAT(run("arm"), Ends(1, HasSubstr("The folder arm is there already.")));
  for (const char* name : {"Arm", "2arm", "my-arm", "../arm", "hgros"}) {
    EXPECT_THAT(run(name), Ends(2, HasSubstr("cannot name a package"))) << name;
  }
}

}  // namespace
}  // namespace hgros::cli

#include <gmock/gmock.h>

#include <string>

#include "hgros/base/error.hpp"
#include "hgros/component/component.hpp"
#include "hgros/component/components.hpp"
#include "support/path.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::ThrowsMessage;

TEST(ComponentTypes, ComeFromALibrary) {
  EXPECT_THAT(LoadComponents(Path("library")), IsSupersetOf({"library/Sink", "library/Source"}));
  EXPECT_THAT(ComponentTypeNames(), IsSupersetOf({"library/Sink", "library/Source"}));
  EXPECT_EQ(FindComponentType("library/Source").name, "library/Source");
  EXPECT_NO_THROW(LoadComponents(Path("library")));  // Again: the same types, no error.
}

TEST(ComponentTypes, OfALibraryRunInASession) {
  (void)LoadComponents(Path("library"));
  Session session(Config::Parse("discovery: {domain: none}"));
  Components components(session);
  const ComponentDescription& source = components.Add({.name = "source", .type = "library/Source"});
  ASSERT_EQ(source.outputs.size(), 1U);
  EXPECT_EQ(source.outputs[0].type, "foxglove.PoseInFrame");
  components.Add({.name = "sink", .type = "library/Sink"});
  components.Join();
  components.Start();
  EXPECT_TRUE(session.WaitForSubscribers("pose", 1, std::chrono::seconds(5)));
}

TEST(ComponentTypes, AreNotFoundIfTheyAreUnknownOrHaveOneNameOrOneThatCannotBeUsed) {
  (void)LoadComponents(Path("library"));
  EXPECT_THAT([] { (void)FindComponentType("library/Sourc"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("no component type \"library/Sourc\""),
                                         HasSubstr("Did you mean \"library/Source\"?"))));
  EXPECT_THAT([] { (void)FindComponentType("library/Twice"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("Two component types are named \"library/Twice\""),
                                         HasSubstr("component_test_library"))));
  EXPECT_THAT([] { (void)FindComponentType("library/bad name"); },
              ThrowsMessage<Error>(HasSubstr("cannot be the name of a component type")));
}

TEST(ComponentTypes, RefuseALibraryThatIsMissingBrokenOrWithoutAComponent) {
  EXPECT_THAT([] { (void)LoadComponents("/nowhere/libmissing.so"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("/nowhere/libmissing.so"), HasSubstr("No such file"))));
  const ScratchFolder folder;
  const std::string broken = folder.Write("libbroken.so", "This is no library.");
  EXPECT_THAT([&] { (void)LoadComponents(broken); }, ThrowsMessage<Error>(HasSubstr("cannot be loaded")));
  EXPECT_THAT([] { (void)LoadComponents(Path("empty_library")); }, ThrowsMessage<Error>(HasSubstr("has no component")));
}

}  // namespace
}  // namespace hgros::test

#include "remote/remote_units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <link.h>

#include <array>
#include <cstdio>
#include <string>

#include "hgros/base/error.hpp"
#include "remote/library_build.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// The library of this project that is loaded, as any library of a component.
std::string LoadedLibrary() {
  std::string file;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t /*size*/, void* found) {
        const std::string name = info->dlpi_name;
        if (name.find("libhgros.so") != std::string::npos) *static_cast<std::string*>(found) = name;
        return 0;
      },
      &file);
  return file;
}

class RemoteUnitsTest : public testing::Test {
 protected:
  RemoteUnitsTest() {
    folder_.Write("a.yaml", "library: \"" + LoadedLibrary() + "\"\ncomponents: [a/A]\n");
    const LibraryBuild build = BuildOf(LoadedLibrary());
    RemoteOrder::Library& library = *start_.add_libraries();
    library.set_name("liba.so");
    library.set_build(build.id);
    library.set_machine(build.machine);
    library.set_type("a/A");
    description_.name = "mapper";
    description_.fingerprints = {{"x.One", 5}, {"x.Two", 0}};
    for (const auto& [type, fingerprint] : description_.fingerprints) {
      RemoteOrder::Fingerprint& one = *start_.add_fingerprints();
      one.set_type(type);
      one.set_value(fingerprint);
    }
  }
  [[nodiscard]] std::vector<std::string> Differences() const {
    return LibraryDifferences(start_, {description_}, ComponentCatalog({folder_.path()}));
  }

  const test::ScratchFolder folder_;
  RemoteOrder::Start start_;
  ComponentDescription description_;
};

TEST_F(RemoteUnitsTest, AnotherBuildIsADifference) {
  EXPECT_THAT(Differences(), IsEmpty());
  start_.mutable_libraries(0)->set_build("00ff");
  EXPECT_THAT(Differences(),
              ElementsAre(AllOf(HasSubstr("The library of a/A is another one here: "), HasSubstr("libhgros.so"),
                                HasSubstr(" has build id " + BuildOf(LoadedLibrary()).id),
                                HasSubstr("liba.so has build id 00ff."))));
  start_.mutable_libraries(0)->set_build("");
  EXPECT_THAT(Differences(), ElementsAre(HasSubstr("liba.so has no build id.")));
}

TEST_F(RemoteUnitsTest, BuildsForAnotherProcessorAreNotCompared) {
  start_.mutable_libraries(0)->set_build("00ff");
  start_.mutable_libraries(0)->set_machine(start_.libraries(0).machine() + 1);
  EXPECT_THAT(Differences(), IsEmpty());
}

TEST_F(RemoteUnitsTest, OtherSchemasAreADifference) {
  description_.fingerprints["x.One"] = 6;
  description_.fingerprints["x.New"] = 7;
  EXPECT_THAT(Differences(), ElementsAre(HasSubstr("x.New"), AllOf(HasSubstr("x.One"), HasSubstr("\"mapper\""))));
}

TEST(LibraryBuildTest, IsThatOfReadelf) {
  FILE* pipe = popen(("readelf -n '" + LoadedLibrary() + "' 2>/dev/null").c_str(), "re");
  ASSERT_NE(pipe, nullptr);
  std::array<char, 256> line{};
  std::string expected;
  while (fgets(line.data(), line.size(), pipe) != nullptr) {
    const std::string text(line.data());
    if (const auto at = text.find("Build ID: "); at != std::string::npos) expected = text.substr(at + 10, 40);
  }
  pclose(pipe);
  if (expected.empty()) GTEST_SKIP() << "readelf is missing.";
  EXPECT_EQ(BuildOf(LoadedLibrary()).id, expected);
}

TEST(LibraryBuildTest, OtherFilesAreRefused) {
  EXPECT_THROW((void)BuildOf("/etc/passwd"), Error);
  EXPECT_THROW((void)BuildOf("/nowhere"), Error);
}

}  // namespace
}  // namespace hgros::cli

#include "hgros/component/component_catalog.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>

#include "hgros/base/error.hpp"
#include "support/path.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::test {
namespace {

using std::filesystem::path;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

// Folders for manifests.
class ComponentCatalogTest : public testing::Test {
 protected:
  ComponentCatalogTest() {
    for (const char* folder : {"first", "second"}) std::filesystem::create_directory(folder_ / folder);
  }
  void Write(const std::string& file, const std::string& text) const { folder_.Write(file, text); }
  [[nodiscard]] ComponentCatalog Catalog() const {
    return ComponentCatalog({folder_ / "first", folder_ / "second", folder_ / "missing"});
  }

  const ScratchFolder folder_;
};

TEST_F(ComponentCatalogTest, HasWhatTheManifestsDescribe) {
  Write("second/words.yaml", "library: ../lib/libwords.so\ncomponents: [words/Source, words/Counter]\n");
  Write("first/robot.yaml", "library: /opt/robot/librobot.so\ncomponents: [robot/Arm]\n");
  Write("first/README", "This is no manifest.");
  const ComponentCatalog catalog = Catalog();
  ASSERT_EQ(catalog.libraries().size(), 2U);
  EXPECT_EQ(catalog.libraries()[0].file, "/opt/robot/librobot.so");
  EXPECT_EQ(catalog.libraries()[1].file, folder_ / "lib" / "libwords.so");
  EXPECT_THAT(catalog.libraries()[1].types, ElementsAre("words/Counter", "words/Source"));
  EXPECT_THAT(catalog.faults(), IsEmpty());
  EXPECT_EQ(catalog.Find("words/Source").manifest, folder_ / "second" / "words.yaml");
}

TEST_F(ComponentCatalogTest, FindsClassesOfPythonInTheLibraryOfThatLanguage) {
  EXPECT_THAT([&] { (void)Catalog().Find("robot.parts:Arm"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("\"robot.parts:Arm\""), HasSubstr("class of Python"))));
  Write("first/python.yaml", "library: /usr/lib/libpython_components.so\nlanguage: python\n");
  EXPECT_EQ(Catalog().Find("robot.parts:Arm").file, "/usr/lib/libpython_components.so");
  EXPECT_THAT(Catalog().Find("robot.parts:Arm").types, IsEmpty());
  EXPECT_THAT([&] { (void)Catalog().Find("robot/Arm"); }, ThrowsMessage<Error>(HasSubstr("no component type")));
}

TEST_F(ComponentCatalogTest, PrefersEarlierFoldersAndNamesTheNearestTypeOrWhereItLooked) {
  Write("first/words.yaml", "library: /new/libwords.so\ncomponents: [words/Source]\n");
  Write("second/words.yaml", "library: /old/libwords.so\ncomponents: [words/Source]\n");
  const ComponentCatalog catalog = Catalog();
  EXPECT_EQ(catalog.Find("words/Source").file, "/new/libwords.so");
  EXPECT_THAT([&] { (void)catalog.Find("words/Sorce"); },
              ThrowsMessage<Error>(HasSubstr("Did you mean \"words/Source\"?")));
  EXPECT_THAT(
      [&] { (void)catalog.Find("robot/Arm"); },
      ThrowsMessage<Error>(AllOf(HasSubstr("HGROS_COMPONENT_PATH"), HasSubstr((folder_ / "missing").string()))));
}

TEST_F(ComponentCatalogTest, SaysWhatIsWrongWithAManifestAndUsesTheOthers) {
  Write("first/a.yaml", "library: x.so\ncomponent: [words/Source]\n");
  Write("first/b.yaml", "library: [x.so\n");
  Write("first/c.yaml", "components: [words/Source]\n");
  Write("first/d.yaml", "library: x.so\ncomponents: [words/Sink]\n");
  const ComponentCatalog catalog = Catalog();
  ASSERT_EQ(catalog.faults().size(), 3U);
  EXPECT_THAT(catalog.faults()[0], AllOf(HasSubstr("a.yaml:2:1"), HasSubstr("components")));
  EXPECT_THAT(catalog.faults()[1], HasSubstr("b.yaml:"));
  EXPECT_THAT(catalog.faults()[2], AllOf(HasSubstr("c.yaml"), HasSubstr("library")));
  EXPECT_NO_THROW((void)catalog.Find("words/Sink"));
  EXPECT_THAT([&] { (void)catalog.Find("words/Source"); }, ThrowsMessage<Error>(HasSubstr("c.yaml")));
}

TEST_F(ComponentCatalogTest, IgnoresWhatIsNoFile) {
  ASSERT_EQ(mkfifo((folder_ / "first" / "pipe.yaml").c_str(), 0600), 0);
  std::filesystem::create_directory(folder_ / "first" / "folder.yaml");
  std::filesystem::create_symlink("/dev/zero", folder_ / "first" / "device.yaml");
  std::filesystem::create_symlink("nowhere", folder_ / "first" / "broken.yaml");
  Write("second/words.yaml", "library: x.so\ncomponents: [words/Source]\n");
  const ComponentCatalog catalog = Catalog();
  EXPECT_EQ(catalog.libraries().size(), 1U);
  EXPECT_THAT(catalog.faults(), IsEmpty());
}

TEST_F(ComponentCatalogTest, LoadsALibraryAndSaysIfItIsAnother) {
  Write("first/good.yaml", "library: " + Path("library") + "\ncomponents: [library/Source, library/Gone]\n");
  Write("first/missing.yaml", "library: libmissing.so\ncomponents: [words/Source]\n");
  const ComponentCatalog catalog = Catalog();
  EXPECT_EQ(catalog.Load("library/Source").name, "library/Source");
  EXPECT_THAT([&] { (void)catalog.Load("library/Gone"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("has no component type \"library/Gone\""), HasSubstr("good.yaml"))));
  EXPECT_THAT([&] { (void)catalog.Load("words/Source"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("libmissing.so"), HasSubstr("cannot be loaded"))));
}

TEST_F(ComponentCatalogTest, LooksInTheFoldersOfTheEnvironmentFirst) {
  setenv("HGROS_COMPONENT_PATH", "/one::/two", 1);
  setenv("XDG_DATA_HOME", "/data", 1);
  setenv("XDG_DATA_DIRS", "/three:/data", 1);
  const std::vector<path> folders = ComponentFolders();
  unsetenv("HGROS_COMPONENT_PATH");
  unsetenv("XDG_DATA_HOME");
  unsetenv("XDG_DATA_DIRS");
  ASSERT_GE(folders.size(), 4U);
  EXPECT_EQ(folders[0], "/one");
  EXPECT_EQ(folders[1], "/two");
  EXPECT_EQ(folders[2], "/data/hgros/components");
  EXPECT_EQ(folders.back(), "/three/hgros/components");
  EXPECT_THAT(ComponentFolders(), Contains("/usr/share/hgros/components"));
}

}  // namespace
}  // namespace hgros::test

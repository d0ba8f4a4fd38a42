#include "hgros/base/error.hpp"

#include <gtest/gtest.h>

namespace hgros {
namespace {

TEST(FilePosition, OmitsUnknownParts) {
  EXPECT_EQ((FilePosition{"net.yaml", 3, 7}).ToString(), "net.yaml:3:7");
  EXPECT_EQ((FilePosition{"net.yaml", 3, 0}).ToString(), "net.yaml:3");
  EXPECT_EQ((FilePosition{"net.yaml", 0, 7}).ToString(), "net.yaml");
  EXPECT_EQ(FilePosition{}.ToString(), "");
}

TEST(FilePosition, IsReadFromItsText) {
  for (const FilePosition& one : {FilePosition{"net.yaml", 3, 7}, FilePosition{"net.yaml", 3, 0},
                                  FilePosition{"a:b/net.yaml", 0, 0}, FilePosition{}}) {
    const FilePosition read = FilePosition::From(one.ToString());
    EXPECT_EQ(read.file, one.file);
    EXPECT_EQ(read.line, one.line);
    EXPECT_EQ(read.column, one.column);
  }
}

TEST(Error, NamesPlaceFaultAndFixAndHasItsSentenceAlone) {
  const Error error("The port is taken.", "net.yaml:3", "Choose another one.");
  EXPECT_STREQ(error.what(), "net.yaml:3: The port is taken. Choose another one.");
  EXPECT_EQ(error.where(), "net.yaml:3");
  EXPECT_EQ(error.mend(), "Choose another one.");
  EXPECT_EQ(error.sentence(), "The port is taken.");
  EXPECT_EQ(Error("The port is taken.").sentence(), "The port is taken.");
  EXPECT_STREQ(Error("The port is taken.").what(), "The port is taken.");
}

TEST(Error, IsUtf8WithAnyName) {
  const Error error("There is no \"caf\xe9.yaml\".", "caf\xe9.yaml:1", "Look into \"\xff\".");
  EXPECT_STREQ(error.what(), R"(caf\xe9.yaml:1: There is no "caf\xe9.yaml". Look into "\xff".)");
  EXPECT_EQ(error.sentence(), R"(There is no "caf\xe9.yaml".)");
}

TEST(Error, KeepsItsPartsWhenCopied) {
  Error copy("");
  {
    const Error original("What.", "where", "Mend.");
    copy = original;
  }
  EXPECT_STREQ(copy.what(), "where: What. Mend.");
  EXPECT_EQ(copy.where(), "where");
}

TEST(ConfigError, PutsTheFilePositionFirstAndIsAnError) {
  const ConfigError config("Unknown key \"ipp\".", FilePosition{"net.yaml", 4, 2}, "Did you mean \"ip\"?");
  const Error& error = config;
  EXPECT_STREQ(error.what(), "net.yaml:4:2: Unknown key \"ipp\". Did you mean \"ip\"?");
  EXPECT_EQ(error.where(), "net.yaml:4:2");
}

TEST(TypeMismatch, IsCaughtAsError) { EXPECT_THROW(throw TypeMismatch("Two types."), Error); }

}  // namespace
}  // namespace hgros

#include "carmen_log.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <numbers>
#include <stdexcept>
#include <string>

#include "support/scratch_folder.hpp"

namespace slam2d {
namespace {

const std::string kTwoScans =
    "# message_name [message contents]\n"
    "PARAM robot_use_laser on nohost 0\n"
    "FLASER 4 1.0 2.5 81.83 4.0 0.5 -0.25 1.5 9 9 9 1000.5 nohost 3.0\n"
    "ODOM 0 0 0 0 0 0 1000.6 nohost 3.1\n"
    "FLASER 4 1.0 2.0 3.0 4.0 0.6 -0.25 1.5 9 9 9 999.75 nohost 3.2";  // A stamp that steps back, no newline.

std::string Message(CarmenLogReader& reader) {
  try {
    while (reader.Next()) {
    }
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

void WriteGzip(const std::filesystem::path& path, const std::string& text) {
  gzFile file = gzopen(path.c_str(), "wb");
  ASSERT_NE(file, nullptr);
  gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
  gzclose(file);
}

TEST(CarmenLog, ReadsScansInFileOrderEvenIfStampsStepBack) {
  const hgros::test::ScratchFolder folder;
  CarmenLogReader reader(folder.Write("two.clf", kTwoScans));
  const auto first = reader.Next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->sequence, 0U);
  EXPECT_EQ(first->stamp_seconds, 1000.5);
  EXPECT_EQ(first->ranges_m, (std::vector<float>{1.0F, 2.5F, 81.83F, 4.0F}));
  EXPECT_EQ(first->odometry, (Pose2{0.5, -0.25, 1.5}));
  EXPECT_DOUBLE_EQ(first->start_angle_rad, -std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(first->angle_step_rad, std::numbers::pi / 4);
  EXPECT_LT(first->max_range_m, 81.0);
  const auto second = reader.Next();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->sequence, 1U);
  EXPECT_EQ(second->stamp_seconds, 999.75);
  EXPECT_FALSE(reader.Next());
  EXPECT_EQ(reader.malformed_lines(), 0U);
}

TEST(CarmenLog, ReadsGzipLikePlainText) {
  const hgros::test::ScratchFolder folder;
  WriteGzip(folder / "two.clf.gz", kTwoScans);
  CarmenLogReader reader(folder / "two.clf.gz");
  EXPECT_TRUE(reader.Next());
  EXPECT_TRUE(reader.Next());
  EXPECT_FALSE(reader.Next());
}

TEST(CarmenLog, SkipsAndCountsMalformedLinesAndNamesTheFirst) {
  const hgros::test::ScratchFolder folder;
  CarmenLogReader reader(folder.Write("bad.clf",
                                      "FLASER 3 1 2\n"
                                      "FLASER x 1 2 3\n"
                                      "FLASER 99999999999999 1 2\n"
                                      "FLASER 2 1 nan 0 0 0 0 0 0 1 h 1\n"
                                      "FLASER 2 1 2 0 0 inf 0 0 0 1 h 1\n"
                                      "FLASER 2 1 2 0 0 0 0 0 0\n"
                                      "FLASER\n"
                                      "FLASER 2 1 2 0 0 0 0 0 0 1.25 h 1\n"));
  const auto scan = reader.Next();
  ASSERT_TRUE(scan);
  EXPECT_EQ(scan->sequence, 0U);
  EXPECT_EQ(scan->stamp_seconds, 1.25);
  EXPECT_FALSE(reader.Next());
  EXPECT_EQ(reader.malformed_lines(), 7U);
  EXPECT_NE(reader.first_malformed().find("bad.clf:1: a range is missing"), std::string::npos)
      << reader.first_malformed();
}

TEST(CarmenLog, ReportsATruncatedGzipFileCutAnywhereAndADamagedOne) {
  const hgros::test::ScratchFolder folder;
  std::string text;
  for (int i = 0; i < 300; ++i) {
    text += "FLASER 3 1 2 " + std::to_string(i * 7919 % 1000) + " 0 0 0 0 0 0 " + std::to_string(i) + " h 1\n";
  }
  WriteGzip(folder / "whole.gz", text);
  const auto size = std::filesystem::file_size(folder / "whole.gz");
  for (const auto kept : {size / 4, size / 2, size - 5}) {
    std::filesystem::copy_file(folder / "whole.gz", folder / "cut.gz",
                               std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(folder / "cut.gz", kept);
    CarmenLogReader reader(folder / "cut.gz");
    EXPECT_NE(Message(reader).find("truncated"), std::string::npos) << kept << " of " << size << " bytes";
  }
  std::fstream file(folder / "whole.gz", std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(40);
  file << "damage damage";
  file.close();
  CarmenLogReader reader(folder / "whole.gz");
  EXPECT_NE(Message(reader).find("cannot be read to its end"), std::string::npos);
}

TEST(CarmenLog, ReportsAMissingFileAnEmptyFileAndAFileWithoutScans) {
  const hgros::test::ScratchFolder folder;
  EXPECT_THROW(CarmenLogReader(folder / "missing.clf"), std::runtime_error);
  CarmenLogReader empty(folder.Write("empty.clf", ""));
  EXPECT_NE(Message(empty).find("has no readable FLASER record among its 0 lines"), std::string::npos);
  CarmenLogReader scanless(folder.Write("scanless.clf", "ODOM 0 0 0 0 0 0 1 h 1\nFLASER 2 1\n"));
  EXPECT_NE(Message(scanless).find("scanless.clf:2"), std::string::npos);
}

}  // namespace
}  // namespace slam2d

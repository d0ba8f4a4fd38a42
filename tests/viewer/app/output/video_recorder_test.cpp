#include "viewer/app/output/video_recorder.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <tuple>

#include "support/error_of.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::viewer {
namespace {

using namespace std::chrono_literals;

/// A folder, first in PATH, with a script that replaces ffmpeg.
class VideoRecorderTest : public ::testing::Test {
 protected:
  VideoRecorderTest() { setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1); }
  ~VideoRecorderTest() override { setenv("PATH", path_.c_str(), 1); }
  void Stand(const std::string& script) const {
    std::filesystem::permissions(folder_.Write("ffmpeg", "#!/bin/sh\n" + script), std::filesystem::perms::owner_all);
  }

  const std::string path_ = getenv("PATH");
  const hgros::test::ScratchFolder folder_;
  // The film is the last argument of the command, after "file:".
  const std::string copies_ = "for word; do last=$word; done; exec cat > \"${last#file:}\"\n";
};

constexpr Viewport kSize{640, 480};

std::vector<std::uint8_t> GrayPicture(const Viewport& size, std::uint8_t value) {
  return std::vector<std::uint8_t>(static_cast<std::size_t>(3 * size.width * size.height), value);
}

TEST_F(VideoRecorderTest, PassesEveryPictureToFfmpeg) {
  Stand(copies_);
  VideoRecorder recorder(folder_ / "film.mp4");
  for (std::uint8_t i = 0; i < 5; ++i) EXPECT_EQ(recorder.Add(kSize, GrayPicture(kSize, i)), "");
  EXPECT_EQ(recorder.pictures(), 5U);
  EXPECT_EQ(recorder.Finish(), "");
  const std::string film = folder_.Read("film.mp4");
  ASSERT_EQ(film.size(), 5U * 640 * 480 * 3);
  EXPECT_EQ(film.front(), 0);
  EXPECT_EQ(film.back(), 4);
}

TEST_F(VideoRecorderTest, CutsOrPadsPicturesToTheSizeOfTheFirst) {
  Stand(copies_);
  VideoRecorder recorder(folder_ / "film.mp4");
  for (const Viewport size : {Viewport{4, 2}, Viewport{2, 3}, Viewport{6, 1}}) {
    EXPECT_EQ(recorder.Add(size, GrayPicture(size, 9)), "");
  }
  EXPECT_EQ(recorder.Finish(), "");
  const std::string film = folder_.Read("film.mp4");
  ASSERT_EQ(film.size(), 3U * 4 * 2 * 3);
  EXPECT_EQ(std::count(film.begin() + 24, film.begin() + 48, 9), 2 * 2 * 3) << "narrower: two columns of two rows";
  EXPECT_EQ(std::count(film.begin() + 48, film.end(), 9), 4 * 3) << "lower: one row";
}

TEST_F(VideoRecorderTest, RepeatsTheLastPicture) {
  Stand(copies_);
  VideoRecorder recorder(folder_ / "film.mp4");
  EXPECT_EQ(recorder.Repeat(), "") << "there is no picture yet";
  EXPECT_EQ(recorder.Add({2, 2}, GrayPicture({2, 2}, 7)), "");
  EXPECT_EQ(recorder.Add({1, 2}, GrayPicture({1, 2}, 8)), "");
  EXPECT_EQ(recorder.Repeat(), "");
  EXPECT_EQ(recorder.Finish(), "");
  const std::string film = folder_.Read("film.mp4");
  ASSERT_EQ(film.size(), 3U * 2 * 2 * 3);
  EXPECT_EQ(film.substr(12, 12), film.substr(24)) << "the last picture is repeated with the film's size";
  EXPECT_EQ(std::count(film.begin() + 24, film.end(), 8), 2 * 3);
}

TEST_F(VideoRecorderTest, KillsFfmpegWhenItDoesNotEnd) {
  Stand("cat > /dev/null; exec sleep 1000\n");
  VideoRecorder recorder(folder_ / "film.mp4", 200ms);
  EXPECT_EQ(recorder.Add({2, 2}, GrayPicture({2, 2}, 1)), "");
  const std::string fault = recorder.Finish();
  EXPECT_NE(fault.find("did not end within 0.6 s and was killed"), std::string::npos) << fault;
  EXPECT_FALSE(recorder.recording());
}

TEST_F(VideoRecorderTest, ReportsOnceThatFfmpegFailedWasKilledOrAcceptsNoData) {
  const std::tuple<const char*, std::chrono::milliseconds, const char*> cases[] = {
      {"echo 'Unknown encoder' >&2\nexit 1\n", 20s, "failed and said: Unknown encoder"},
      {"kill -9 $$\n", 20s, "was killed"},
      {"exec sleep 1000\n", 200ms, "accepted no picture for 0.2 s"}};
  for (const auto& [script, patience, words] : cases) {
    SCOPED_TRACE(words);
    Stand(script);
    VideoRecorder recorder(folder_ / "film.mp4", patience);
    std::string fault;
    for (int i = 0; i < 100 && fault.empty(); ++i) fault = recorder.Add(kSize, GrayPicture(kSize, 1));
    EXPECT_NE(fault.find(words), std::string::npos) << fault;
    EXPECT_FALSE(recorder.recording());
    EXPECT_EQ(recorder.Add(kSize, GrayPicture(kSize, 1)), "");
    EXPECT_EQ(recorder.Finish(), "");
  }
}

TEST_F(VideoRecorderTest, ReportsMissingFfmpeg) {
  setenv("PATH", folder_.path().c_str(), 1);
  const std::string fault = hgros::test::ErrorOf([&] { const VideoRecorder recorder(folder_ / "film.mp4"); });
  EXPECT_NE(fault.find("package ffmpeg"), std::string::npos) << fault;
}

TEST_F(VideoRecorderTest, ReportsAFilmWithoutPictures) {
  Stand(copies_);
  VideoRecorder recorder(folder_ / "film.mp4");
  EXPECT_NE(recorder.Finish().find("No picture"), std::string::npos);
}

}  // namespace
}  // namespace hgros::viewer

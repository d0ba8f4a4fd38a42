#include <gmock/gmock.h>
#include <imgui.h>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/RawImage.pb.h"
#include "support/scratch_folder.hpp"
#include "viewer/app/output/png_file.hpp"
#include "viewer/panels/image_panel.hpp"
#include "viewer/panels/widgets/imgui_renderer.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr std::uint32_t kWidth = 80;
constexpr std::uint32_t kHeight = 60;

foxglove::RawImage Raw(const std::string& encoding, std::uint32_t pixel_bytes) {
  foxglove::RawImage image;
  image.set_frame_id("camera");
  image.set_width(kWidth);
  image.set_height(kHeight);
  image.set_encoding(encoding);
  image.set_step(kWidth * pixel_bytes);
  return image;
}

/// Red grows to the right, green downwards, with a blue frame.
foxglove::RawImage Colors() {
  foxglove::RawImage image = Raw("rgb8", 3);
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const bool frame = x < 2 || y < 2 || x + 2 >= kWidth || y + 2 >= kHeight;
      for (const std::uint32_t part : {frame ? 0 : 3 * x, frame ? 0 : 4 * y, frame ? 255 : 40U}) {
        image.mutable_data()->push_back(static_cast<char>(part));
      }
    }
  }
  return image;
}

/// Millimeters of a slope, with a hole in the middle where nothing was measured.
foxglove::RawImage Depth() {
  foxglove::RawImage image = Raw("16UC1", 2);
  for (std::uint32_t y = 0; y < kHeight; ++y) {
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const bool hole = x > 30 && x < 50 && y > 20 && y < 40;
      const auto depth = static_cast<std::uint16_t>(hole ? 0 : 500 + 40 * x + 10 * y);
      image.mutable_data()->append(reinterpret_cast<const char*>(&depth), sizeof depth);
    }
  }
  return image;
}

/// The bytes of an image on the GPU, 4 for each pixel.
std::vector<std::uint8_t> OnGpu(const Display& display) {
  const auto image = display.Image();
  if (!image) return {};
  std::vector<std::uint8_t> pixels(4 * image->picture->width * image->picture->height);
  glBindTexture(GL_TEXTURE_2D, image->texture);
  glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  return pixels;
}

/// Has an ImGui context with its own font and no saved settings.
class ImageDisplayTest : public SceneTest {
 protected:
  void SetUp() override {
    SceneTest::SetUp();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::GetIO().DisplaySize = {static_cast<float>(kPictureSize.width), static_cast<float>(kPictureSize.height)};
  }
  void TearDown() override { ImGui::DestroyContext(); }

  /// Draws the panel with the pointer there.
  Pixels DrawPanels(ImVec2 pointer = {-1, -1}, float wheel = 0) {
    ImguiRenderer renderer;
    for (int frame = 0; frame < 3; ++frame) {  // ImGui needs several frames to lay out a window.
      (void)Draw();
      ImGui::GetIO().MousePos = pointer;
      ImGui::GetIO().MouseWheel = frame == 2 ? wheel : 0;
      EXPECT_TRUE(renderer.Prepare());
      ImGui::NewFrame();
      (void)panel_.Draw(scene_, {4, 4, 312, 232}, 0);
      ImGui::Render();
      renderer.Draw();
    }
    return scene_.picture().Pixels();
  }

  ImagePanel panel_;
};

TEST_F(ImageDisplayTest, DrawsColorsAndZoomsTowardThePointer) {
  Show("Image", "camera", Colors());
  (void)DrawPanels();
  ExpectDrawnAsKept("image_colors");
  const Pixels whole = DrawPanels({250, 150});
  EXPECT_GT(DifferentShare(whole, DrawPanels({250, 150}, 5)), 0.05);
}

TEST_F(ImageDisplayTest, DrawsDepths) {
  Display& display = Show("Image", "depth", Depth());
  (void)DrawPanels({250, 150});
  ExpectDrawnAsKept("image_depth");
  EXPECT_THAT(display.Status(), Contains(HasSubstr("from 500 to 4250")));
  EXPECT_EQ(display.Legend().value().highest, 4250);
}

TEST_F(ImageDisplayTest, UsesTheColorMapOfItsSettings) {
  Display& display = Show("Image", "depth", Depth(), {"map", "gray"});
  const std::vector<std::uint8_t> gray = OnGpu(display);
  ASSERT_FALSE(gray.empty());
  EXPECT_EQ(gray[0], gray[1]);
  Set(display, "auto range", "off");
  Set(display, "highest", "500");
  Update();
  EXPECT_THAT(display.Status(), Contains(HasSubstr("from 0 to 500")));
  EXPECT_EQ(OnGpu(display)[0], 255);
}

TEST_F(ImageDisplayTest, ReturnsTheValueOfAPixel) {
  Display& depths = Show("Image", "depth", Depth());
  Display& colors = Show("Image", "camera", Colors());
  EXPECT_EQ(depths.PixelText(1, 2), "560");
  EXPECT_EQ(depths.PixelText(40, 30), "nothing measured");
  EXPECT_EQ(colors.PixelText(10, 20), "red 30, green 80, blue 40");
  EXPECT_EQ(colors.PixelText(kWidth, 0), "") << "outside";
  foxglove::RawImage gray = Raw("mono8", 1);
  gray.set_data(std::string(std::size_t{kWidth} * kHeight, '\x55'));
  Send("camera", gray);
  EXPECT_EQ(colors.PixelText(10, 20), "85");
}

TEST_F(ImageDisplayTest, KeepsPixelsOnlyOnTheGpu) {
  const std::pair<const char*, std::uint32_t> encodings[] = {{"mono8", 1}, {"mono16", 1}, {"rgb8", 4},
                                                             {"16UC1", 4}, {"32FC1", 4},  {"bayer_rggb8", 4}};
  for (const auto& [encoding, gpu_bytes] : encodings) {
    const std::string name = encoding;
    const std::uint32_t bytes = name == "rgb8" ? 3 : name == "32FC1" ? 4 : name.find("16") != name.npos ? 2 : 1;
    foxglove::RawImage image = Raw(name, bytes);
    image.set_data(std::string(std::size_t{kWidth} * kHeight * bytes, '\x3e'));
    Display& display = Show("Image", name, image);
    ASSERT_TRUE(display.Image()) << name;
    const ImagePicture& picture = *display.Image()->picture;
    EXPECT_EQ(picture.rgba.capacity() + picture.gray.capacity() + picture.values.capacity(), 0U) << name;
    EXPECT_EQ(display.gpu_bytes(), std::size_t{kWidth} * kHeight * gpu_bytes) << name;
  }
}

TEST_F(ImageDisplayTest, DrawsGrayImagesLikeColoredOnes) {
  Display& display = Add("Image", "camera");
  const auto drawn = [&](const std::string& encoding, std::uint32_t bytes) {
    foxglove::RawImage image = Raw(encoding, bytes);
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i)
      image.mutable_data()->append(bytes, static_cast<char>(i % 251));
    Send("camera", image);
    EXPECT_TRUE(display.Image());
    return DrawPanels();
  };
  const Pixels colored = drawn("rgb8", 3);
  const Pixels gray = drawn("mono8", 1);
  EXPECT_LT(DifferentShare(gray, colored), 0.02) << "except the name of the encoding";
  EXPECT_LT(DifferentShare(gray, drawn("rgb8", 3)), 0.02) << "and again";
}

TEST_F(ImageDisplayTest, DrawsCompressedImages) {
  const hgros::test::ScratchFolder folder;
  const std::string colors = Colors().data();
  ASSERT_EQ(WritePng(folder / "image.png", {kWidth, kHeight}, Pixels(colors.begin(), colors.end())), "");
  foxglove::CompressedImage image;
  image.set_format("png");
  image.set_data(folder.Read("image.png"));
  Display& display = Show("Compressed image", "camera", image);
  ASSERT_TRUE(display.Image());
  EXPECT_EQ(display.PixelText(10, 20), "red 30, green 80, blue 40");
}

TEST_F(ImageDisplayTest, ReportsInvalidImages) {
  Display& display = Add("Image", "camera");
  EXPECT_THAT(display.Status().front(), HasSubstr("Nothing has arrived"));
  foxglove::RawImage image = Colors();
  image.set_encoding("smell");
  Send("camera", image);
  EXPECT_TRUE(display.HasFault());
  EXPECT_THAT(display.Status().front(), HasSubstr("smell"));
  EXPECT_FALSE(display.Image());
  Send("camera", Colors());
  EXPECT_FALSE(display.HasFault());
  EXPECT_TRUE(display.Image());
}

TEST_F(ImageDisplayTest, ShowsNoImageWithoutPixels) {
  Display& display = Add("Image", "camera");
  for (const bool wide : {true, false}) {
    Send("camera", Colors());
    EXPECT_TRUE(display.Image());
    foxglove::RawImage image;
    image.set_encoding("mono8");
    image.set_width(wide ? 4'000'000'000 : 0);
    image.set_step(image.width());
    image.set_height(wide ? 0 : 4'000'000'000);
    Send("camera", image);
    EXPECT_FALSE(display.Image());
    EXPECT_THAT(display.Status().front(), HasSubstr("no pixels"));
    EXPECT_EQ(display.PixelText(0, 0), "");
  }
}

TEST_F(ImageDisplayTest, AppliesSettingsWhilePaused) {
  Display& display = Show("Image", "image", Depth());
  const std::vector<std::uint8_t> before = OnGpu(display);
  Publish("image", Colors());
  SetStandingStill(display, "map", "gray");
  const std::vector<std::uint8_t> standing = OnGpu(display);
  EXPECT_NE(standing, before);
  Display& fresh = Show("Image", "fresh", Depth(), {"map", "gray"});
  EXPECT_EQ(standing, OnGpu(fresh));
}

}  // namespace
}  // namespace hgros::viewer::test

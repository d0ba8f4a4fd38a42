#include "viewer/scene/scene_fixture.hpp"

#include <png.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "hgros/base/error.hpp"
#include "support/path.hpp"
#include "viewer/app/output/png_file.hpp"

namespace hgros::viewer::test {
namespace {

constexpr int kClearly = 48;         // of 255, in one channel
constexpr double kTolerance = 0.01;  // of the pixels: renderers differ at the edges of points and lines

std::string Read(const std::filesystem::path& file, Pixels& pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, file.c_str()) == 0) return image.message;
  image.format = PNG_FORMAT_RGB;
  pixels.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0) return image.message;
  return {};
}

}  // namespace

double DifferentShare(const Pixels& a, const Pixels& b) {
  if (a.size() != b.size()) return 1;
  std::size_t different = 0;
  for (std::size_t i = 0; i + 2 < a.size(); i += 3) {
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(static_cast<int>(a[i + c]) - b[i + c]));
    different += most > kClearly ? 1U : 0U;
  }
  return 3.0 * static_cast<double>(different) / static_cast<double>(a.size());
}

void DrawingTest::SetUp() {
  // One context for all tests, never destroyed: making one takes longer than a test.
  static Offscreen* surface = nullptr;
  if (surface != nullptr) return;
  try {
    surface = new Offscreen(kPictureSize);
  } catch (const Error& error) {
    GTEST_SKIP() << error.what();
  }
}

Display& SceneTest::Add(const std::string& type, const std::string& channel, const std::vector<std::string>& settings) {
  Display& display = *scene_.Add(*DisplayTypeNamed(type), {session_, channel, [] {}}).display;
  for (std::size_t i = 0; i + 1 < settings.size(); i += 2) Set(display, settings[i], settings[i + 1]);
  return display;
}

void SceneTest::Set(Display& display, const std::string& name, const std::string& text) {
  const std::vector<Setting> known = display.Settings();
  const auto setting = std::ranges::find(known, name, &Setting::name);
  ASSERT_NE(setting, known.end()) << name;
  EXPECT_EQ(SetFromText(*setting, text), "");
  display.OnSetting(name);
}

std::string SceneTest::SettingText(Display& display, const std::string& name) {
  const std::vector<Setting> known = display.Settings();
  return TextOf(*std::ranges::find(known, name, &Setting::name));
}

void SceneTest::Update(double now_s) {
  ASSERT_TRUE(session_.WaitIdle(std::chrono::seconds(10)));
  const bool frame_changed = transforms_changed_ && frame_.Refresh();
  scene_.Update({frame_, now_s, frame_changed, transforms_changed_});
  transforms_changed_ = false;
}

void SceneTest::SetStandingStill(Display& display, const std::string& name, const std::string& text) {
  ASSERT_TRUE(session_.WaitIdle(std::chrono::seconds(10)));
  Set(display, name, text);
  scene_.ApplySettings({frame_, 0, false, false});
}

Pixels SceneTest::Draw() {
  const ViewMatrices view = camera_.Matrices(kPictureSize);
  scene_.Draw(view, 1);
  while (scene_.unfinished()) scene_.Draw(view, 1);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  return scene_.picture().Pixels();
}

void SceneTest::ExpectAsKept(const std::string& name) {
  (void)Draw();
  ExpectDrawnAsKept(name);
}

void SceneTest::ExpectDrawnAsKept(const std::string& name) {
  const Pixels pixels = scene_.picture().Pixels();
  const std::filesystem::path kept = std::filesystem::path(hgros::test::Path("kept_pictures")) / (name + ".png");
  if (std::getenv("HGROS_KEEP_PICTURES") != nullptr) {
    ASSERT_EQ(WritePng(kept, kPictureSize, pixels), "");
    return;
  }
  Pixels expected;
  ASSERT_EQ(Read(kept, expected), "") << kept;
  const double share = DifferentShare(pixels, expected);
  if (share <= kTolerance) return;
  const std::string drawn = name + "_drawn.png";
  (void)WritePng(drawn, kPictureSize, pixels);
  ADD_FAILURE() << share * 100 << " % of the pixels differ from " << kept << "; the drawn picture is in "
                << std::filesystem::absolute(drawn);
}

}  // namespace hgros::viewer::test

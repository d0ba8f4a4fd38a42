#include "viewer/app/output/picture_writer.hpp"

#include <ctime>
#include <string>
#include <system_error>
#include <utility>

#include "viewer/app/output/png_file.hpp"
#include "viewer/data/free_name.hpp"
#include "viewer/scene/gl/picture.hpp"

namespace hgros::viewer {

void PictureWriter::RequestScreenshot(std::filesystem::path file) { screenshot_ = std::move(file); }

void PictureWriter::RequestScreenshotNamedByTime() {
  char name[64];
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  std::strftime(name, sizeof name, "hgros-viewer-%Y%m%d-%H%M%S.png", &parts);
  RequestScreenshot(FreeName(name));  // Another picture of this second is not replaced.
}

void PictureWriter::Write() {
  if (!screenshot_.empty()) WriteScreenshot(std::exchange(screenshot_, {}));
  if (!film_ || !film_->recording()) return;
  const std::string fault = film_->Add(surface_.size(), ReadPixels());
  if (!fault.empty()) notices_.Fail(fault);
}

void PictureWriter::WriteScreenshot(const std::filesystem::path& file) {
  const std::string fault = WritePng(file, surface_.size(), ReadPixels());
  std::error_code ignored;
  notices_.Show("wrote " + std::filesystem::absolute(file, ignored).string());
  if (!fault.empty()) notices_.Fail(fault);
}

void PictureWriter::FinishFilm() {
  if (!film_) return;
  std::string fault = film_->Repeat();  // The last picture is shown until now.
  if (fault.empty()) fault = film_->Finish();
  if (!fault.empty()) notices_.Fail(fault);
}

std::vector<std::uint8_t> PictureWriter::ReadPixels() const {
  Picture copy;
  copy.Resize(surface_.size());
  copy.TakeFrom(surface_.framebuffer());
  return copy.Pixels();
}

}  // namespace hgros::viewer

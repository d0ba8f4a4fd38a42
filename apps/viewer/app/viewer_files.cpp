#include <cstdio>
#include <filesystem>
#include <system_error>

#include "viewer/app/png_file.hpp"
#include "viewer/app/viewer.hpp"

namespace hgros::viewer {

std::vector<std::uint8_t> Viewer::ShownPixels() const {
  Picture copy;
  copy.Resize(surface_.size());
  copy.TakeFrom(surface_.framebuffer());
  return copy.Pixels();
}

void Viewer::Complain(const std::string& fault) {
  notice_ = fault;
  std::fprintf(stderr, "hgros-viewer: %s\n", fault.c_str());
  exit_code_ = 1;
}

void Viewer::WriteScreenshot(const std::filesystem::path& file) {
  const std::string fault = WritePng(file, surface_.size(), ShownPixels());
  std::error_code ignored;
  notice_ = "wrote " + std::filesystem::absolute(file, ignored).string();
  if (!fault.empty()) Complain(fault);
}

void Viewer::RecordFrame() {
  const std::string fault = film_->Add(surface_.size(), ShownPixels());
  if (!fault.empty()) Complain(fault);
}

void Viewer::FinishFilm() {
  std::string fault = film_->Repeat();  // The last picture is seen until now.
  if (fault.empty()) fault = film_->Finish();
  if (!fault.empty()) Complain(fault);
}

}  // namespace hgros::viewer

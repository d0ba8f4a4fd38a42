#include "viewer/app/notices.hpp"

#include <cstdio>

namespace hgros::viewer {

void Notices::Print(const std::string& line) { std::fprintf(stderr, "hgros-viewer: %s\n", line.c_str()); }

void Notices::ShowAndPrint(const std::string& notice) {
  shown_ = notice;
  Print(notice);
}

void Notices::Fail(const std::string& fault) {
  ShowAndPrint(fault);
  SetFailed();
}

}  // namespace hgros::viewer

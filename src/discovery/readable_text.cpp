#include "discovery/readable_text.hpp"

namespace hgros::discovery {

std::string Readable(std::string_view text) {
  std::string readable(text.substr(0, kMaxTextBytes));
  for (char& c : readable) {
    if (static_cast<unsigned char>(c) < 0x20 || c == '\x7f') c = '?';
  }
  return readable;
}

}  // namespace hgros::discovery

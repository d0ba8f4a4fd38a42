#include "terminal/output_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "hgros/base/error.hpp"
#include "terminal/console.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {

void WriteTo(Console& console, const std::string& file, std::string_view text) {
  if (file.empty()) {
    console.Write(console.interactive() ? VisibleLines(text) : std::string(text));
    return;
  }
  errno = 0;
  std::ofstream out(file, std::ios::binary);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out) throw Error("The file " + file + " cannot be written: " + std::strerror(errno) + ".");
}

}  // namespace hgros::cli

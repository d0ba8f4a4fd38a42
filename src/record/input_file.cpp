#include "record/input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hgros/base/error.hpp"

namespace hgros::mcap {

InputFile::InputFile(const std::filesystem::path& path)
    : path_(path), descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  struct stat about {};
  if (descriptor_ < 0 || fstat(descriptor_, &about) != 0) {
    const int error = errno;
    if (descriptor_ >= 0) close(descriptor_);
    throw Error(fmt::format("\"{}\" cannot be read: {}.", name(), std::strerror(error)));
  }
  if (S_ISREG(about.st_mode)) size_ = static_cast<std::uint64_t>(about.st_size);
  std::string why = S_ISREG(about.st_mode) ? "It does not begin as one." : "It is no regular file.";
  Buffer magic;
  try {
    Read(0, kMagic.size(), magic);
  } catch (const Malformed& error) {
    magic.clear();
    if (size_ >= kMagic.size()) why = fmt::format("It cannot be read: {}.", error.what());
  }
  if (AsText(magic) != kMagic) {
    close(descriptor_);
    throw Error(fmt::format("\"{}\" is not an MCAP file.", name()), {}, why);
  }
}

InputFile::~InputFile() { close(descriptor_); }

Bytes InputFile::Read(std::uint64_t offset, std::uint64_t size, Buffer& into) const {
  if (offset > size_ || size > size_ - offset) throw Malformed("the file ends too early");
  if (size > kMaxReadBytes)
    throw Malformed(fmt::format("it has {} bytes, and at most {} are read", size, kMaxReadBytes));
  into.resize(size);
  for (std::uint64_t done = 0; done < size;) {
    const ssize_t got = pread(descriptor_, into.data() + done, size - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Malformed(fmt::format("the system reports: {}", std::strerror(errno)));
    if (got == 0) throw Malformed("the file was shortened meanwhile");
    done += static_cast<std::uint64_t>(got);
  }
  return into;
}

}  // namespace hgros::mcap

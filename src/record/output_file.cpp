#include "record/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hgros/base/error.hpp"

namespace hgros::mcap {

namespace {

const char* Mend(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT: return "Make room there, or write to another disk.";
    case EEXIST: return "Give another name, or remove that file.";
    case ENOENT: return "Create the folder first.";
    case EFBIG: return "The disk's format or a limit of the process allows no larger file: split the recording.";
    default: return "";
  }
}

}  // namespace

OutputFile::OutputFile(const std::filesystem::path& path)
    : path_(path), descriptor_(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) Fail("created");
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void OutputFile::Append(const std::array<Bytes, kMaxPieces>& pieces) {
  std::array<iovec, kMaxPieces> vectors{};
  std::size_t count = 0;
  std::uint64_t left = 0;
  for (const Bytes piece : pieces) {
    if (piece.empty()) continue;
    vectors[count++] = {const_cast<std::byte*>(piece.data()), piece.size()};
    left += piece.size();
  }
  const std::uint64_t end = size_ + left;
  for (iovec* next = vectors.data(); left != 0;) {
    const ssize_t written =
        pwritev(descriptor_, next, static_cast<int>(vectors.data() + count - next), static_cast<off_t>(end - left));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int error = written < 0 ? errno : ENOSPC;
      (void)!ftruncate(descriptor_, static_cast<off_t>(size_));  // A reader leaves out what remains otherwise.
      errno = error;
      Fail("written");
    }
    left -= static_cast<std::uint64_t>(written);
    for (auto done = static_cast<std::size_t>(written); done != 0;) {
      const std::size_t some = std::min(done, next->iov_len);
      next->iov_base = static_cast<std::byte*>(next->iov_base) + some;
      next->iov_len -= some;
      done -= some;
      if (next->iov_len == 0) ++next;
    }
  }
  size_ = end;
}

void OutputFile::Sync() {
  if (fdatasync(descriptor_) != 0 && errno != EINVAL && errno != EROFS) Fail("written to the disk");
  if (std::exchange(has_name_on_disk_, true)) return;
  const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // A folder that may not be listed.
  (void)fsync(descriptor);
  close(descriptor);
}

void OutputFile::Remove() noexcept { unlink(path_.c_str()); }

void OutputFile::Close() {
  if (close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) Fail("written");
}

void OutputFile::Fail(const char* what) {
  const int error = errno;
  throw Error(fmt::format("\"{}\" cannot be {}: {}.", path_.string(), what, std::strerror(error)), {}, Mend(error));
}

}  // namespace hgros::mcap

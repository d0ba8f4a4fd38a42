#include "params/replaced_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>

#include "hgros/base/error.hpp"
#include "hgros/base/own_descriptor.hpp"

namespace hgros {
namespace {

[[noreturn]] void Fail(const std::filesystem::path& file, int error) {
  throw Error(std::string("The parameters cannot be saved: ") + std::strerror(error) + ".", file.string(),
              "Check the folder, its permissions and the space on the disk.");
}

bool WriteAll(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

void ReplaceFile(const std::filesystem::path& file, std::string_view text) {
  std::error_code fault;
  std::filesystem::path target = std::filesystem::weakly_canonical(file, fault);
  if (fault) target = std::filesystem::absolute(file);
  std::string unfinished = (target.parent_path() / ("." + target.filename().string() + ".XXXXXX")).string();
  const OwnDescriptor descriptor([&] { return mkostemp(unfinished.data(), O_CLOEXEC); });
  if (!descriptor) Fail(file, errno);
  struct stat status {};
  const mode_t mode = stat(target.c_str(), &status) == 0 ? status.st_mode & 07777U : 0644U;
  if (fchmod(descriptor.get(), mode) != 0 || !WriteAll(descriptor.get(), text) || fsync(descriptor.get()) != 0 ||
      std::rename(unfinished.c_str(), target.c_str()) != 0) {
    const int error = errno;
    unlink(unfinished.c_str());
    Fail(file, error);
  }
  // Makes the new name survive a crash, too.
  const OwnDescriptor folder([&] { return open(target.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); });
  if (folder) (void)fsync(folder.get());
}

}  // namespace hgros

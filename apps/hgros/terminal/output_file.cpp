#include "terminal/output_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "hgros/base/error.hpp"
#include "terminal/console.hpp"
#include "terminal/visible_text.hpp"

namespace hgros::cli {
namespace {

[[noreturn]] void ThrowUnwritable(const std::string& file) {
  throw Error("The file " + file + " cannot be written: " + std::strerror(errno) + ".");
}

// A device or a pipe takes the text as it comes.
void WriteInto(const Console& console, const std::string& file, std::string_view text) {
  // O_NONBLOCK: otherwise this waits for a reader, and no signal ends it.
  struct Opened {
    ~Opened() {
      if (descriptor >= 0) close(descriptor);
    }
    int descriptor;
  } const out{open(file.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK)};
  if (out.descriptor < 0 && errno == ENXIO) throw Error("Nobody reads the pipe " + file + ". Start its reader first.");
  if (out.descriptor < 0) ThrowUnwritable(file);
  const std::string visible = isatty(out.descriptor) == 1 ? VisibleLines(text) : std::string(text);
  console.WriteTo(out.descriptor, "The file " + file, visible);
}

// Where symbolic links lead, whether a file is there or not. Throws Error for a link to nowhere.
std::filesystem::path TargetOf(const std::string& file) {
  constexpr int kMostLinks = 40;  // As Linux.
  std::filesystem::path target = file;
  std::error_code fault;
  for (int links = 0; std::filesystem::is_symlink(target, fault); ++links) {
    if (links == kMostLinks) throw Error("The file " + file + " is a symbolic link that leads in a circle.");
    target = target.parent_path() / std::filesystem::read_symlink(target, fault);
  }
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : ".";
  if (target != file && !std::filesystem::is_directory(folder, fault)) {
    throw Error("The file " + file + " is a symbolic link to " + target.string() + ", whose folder is not there.");
  }
  return target;
}

// A file beside the one that is written, which takes its place once it is complete.
class FileBeside {
 public:
  FileBeside(const std::string& file, mode_t mode) : file_(file), name_(file + ".XXXXXX") {
    descriptor_ = mkostemp(name_.data(), O_CLOEXEC);
    if (descriptor_ < 0) ThrowUnwritable(file_);
    (void)fchmod(descriptor_, mode);
  }
  FileBeside(const FileBeside&) = delete;
  FileBeside& operator=(const FileBeside&) = delete;
  ~FileBeside() {
    if (descriptor_ >= 0) close(descriptor_);
    if (!complete_) (void)unlink(name_.c_str());
  }
  void Complete(const Console& console, std::string_view text) {
    console.WriteTo(descriptor_, "The file " + file_, text);
    // Some disks say only now that they are full.
    if (fsync(descriptor_) != 0 && errno != EINVAL) ThrowUnwritable(file_);
    if (rename(name_.c_str(), file_.c_str()) != 0) ThrowUnwritable(file_);
    complete_ = true;
  }

 private:
  const std::string file_;
  std::string name_;
  int descriptor_ = -1;
  bool complete_ = false;
};

}  // namespace

void WriteTo(Console& console, const std::string& file, std::string_view text) {
  if (file.empty()) {
    console.Write(console.interactive() ? VisibleLines(text) : std::string(text));
    return;
  }
  struct stat status {};
  const bool exists = stat(file.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) throw Error(file + " is a folder. Name a file in it.");
  if (exists && !S_ISREG(status.st_mode)) return WriteInto(console, file, text);
  const mode_t mask = umask(0);
  (void)umask(mask);
  constexpr mode_t kAllRead = 0666;
  // A link stays a link.
  FileBeside beside(TargetOf(file).string(), exists ? status.st_mode & 07777 : kAllRead & ~mask);
  beside.Complete(console, text);
}

}  // namespace hgros::cli

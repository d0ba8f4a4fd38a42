#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/own_descriptor.hpp"

namespace hgros {

// Watches files, and the links and folders on the way to them.
//
// Thread safety: none.
// Invariants: entries_ has the links and folders that the kernel passes on the way to each file, and the file. Each
//   has its folder watched before it is looked up, so a later change is an event. Folders that this process may not
//   read are left out, except that of the file itself.
class WatchedFiles {
 public:
  // The file at a path, or why there is none.
  struct Target {
    int error = 0;      // Of stat(); 0: there is a file.
    bool open = false;  // A new file that its writer has not closed yet.
    int watch = 0;      // The folder's. A new file in a new folder may be like the old one in all other fields.
    dev_t device = 0;
    ino_t inode = 0;
    off_t size_bytes = 0;
    std::int64_t modified_ns = 0;
    bool operator==(const Target&) const = default;
  };
  enum class News {
    kNone,
    kMoved,    // A path may lead to another file, or to none.
    kWritten,  // The same, or a file has new content; what is new is complete.
  };

  // Throws Error if there is no inotify.
  explicit WatchedFiles(const std::vector<std::filesystem::path>& files);
  // Looks up all files again, and watches what is on the way now. Call it after news. Throws Error if something cannot
  // be watched; everything else is.
  void LookUp();
  // All news so far, without waiting.
  [[nodiscard]] News Read();
  // In the order of the files.
  [[nodiscard]] std::vector<Target> Targets() const;
  // Readable when there are news.
  [[nodiscard]] int fd() const noexcept { return inotify_.get(); }

 private:
  using Key = std::pair<int, std::string>;  // The watch of a folder, and a name in it.
  struct Entry {
    std::uint64_t look_up = 0;  // The last one that passed here.
    bool open = false;          // Created, and not closed since.
  };
  struct File {
    std::filesystem::path path;
    Key last;  // The entry of the file itself.
  };

  [[nodiscard]] std::optional<Error> LookUpOne(File& file);
  [[nodiscard]] News Sort(std::uint32_t mask, const Key& key);
  void DropPassed();
  [[nodiscard]] bool HasEntries(int watch) const;

  OwnDescriptor inotify_;
  std::vector<File> files_;
  std::map<Key, Entry> entries_;
  std::uint64_t look_up_ = 0;
};

}  // namespace hgros

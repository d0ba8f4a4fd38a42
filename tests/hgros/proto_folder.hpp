#pragma once

#include <filesystem>
#include <string>

#include "support/scratch_folder.hpp"

namespace hgros::cli {

/// A folder with .proto files of a test, removed at its end.
class ProtoFolder : public test::ScratchFolder {
 public:
  /// Returns the path of the written file.
  [[nodiscard]] std::string Write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((*this / name).parent_path());
    return ScratchFolder::Write(name, text).string();
  }
  [[nodiscard]] std::string path() const { return ScratchFolder::path().string(); }
};

}  // namespace hgros::cli

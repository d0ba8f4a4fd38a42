#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "hgros/base/export.hpp"
#include "hgros/component/component.hpp"

namespace hgros {

/// A shared library with components, as its manifest describes it.
struct ComponentLibrary {
  std::filesystem::path manifest;  ///< FOLDER/NAME.yaml, written by hgros_add_components().
  std::filesystem::path file;      ///< Of the library; absolute.
  std::vector<std::string> types;  ///< Such as "slam2d/Mapper"; sorted.
  std::string language = {};       ///< "python": it finds the types MODULE:CLASS by their names, and `types` is empty.
};

/// Where manifests are looked for, the first ones first: the folders of HGROS_COMPONENT_PATH (separated by colons),
/// then hgros/components in XDG_DATA_HOME, in the share folder beside this library, and in XDG_DATA_DIRS. Folders need
/// not exist.
[[nodiscard]] HGROS_EXPORT std::vector<std::filesystem::path> ComponentFolders();

/// The component libraries that are installed. Reads their manifests and loads none.
///
/// Thread safety: const functions.
class HGROS_EXPORT ComponentCatalog {
 public:
  explicit ComponentCatalog(std::vector<std::filesystem::path> folders = ComponentFolders());

  /// In the order of the folders, then by name. If two have a type of one name, the first one is used.
  [[nodiscard]] const std::vector<ComponentLibrary>& libraries() const noexcept { return libraries_; }
  /// A sentence for each manifest that cannot be used.
  [[nodiscard]] const std::vector<std::string>& faults() const noexcept { return faults_; }

  /// The library with that type. Throws Error that names the nearest type, or the folders.
  [[nodiscard]] const ComponentLibrary& Find(std::string_view type) const;
  /// The type, from the program or from its library, which is loaded if it was not before. Throws Error if there is no
  /// such type, if its library cannot be loaded, or if it does not have what its manifest says.
  [[nodiscard]] const ComponentType& Load(std::string_view type) const;

 private:
  void Read(const std::filesystem::path& manifest);

  std::vector<std::filesystem::path> folders_;
  std::vector<ComponentLibrary> libraries_;
  std::vector<std::string> faults_;
};

}  // namespace hgros

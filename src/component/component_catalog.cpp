#include "hgros/component/component_catalog.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/yaml/document.hpp"
#include "hgros/yaml/reader.hpp"

namespace hgros {
namespace {

using std::filesystem::path;

void AddFolders(const char* variable, std::string_view otherwise, const path& below, std::vector<path>& folders) {
  const char* set = std::getenv(variable);
  std::string_view rest = set != nullptr && *set != '\0' ? std::string_view(set) : otherwise;
  while (!rest.empty()) {
    const std::size_t end = rest.find(':');
    if (const std::string_view one = rest.substr(0, end); !one.empty())
      folders.push_back(below.empty() ? path(one) : path(one) / below);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
}

const path kBelowShare = path("hgros") / "components";

}  // namespace

std::vector<path> ComponentFolders() {
  std::vector<path> folders;
  AddFolders("HGROS_COMPONENT_PATH", "", "", folders);
  const char* home = std::getenv("HOME");
  AddFolders("XDG_DATA_HOME", home != nullptr && *home != '\0' ? std::string(home) + "/.local/share" : std::string(),
             kBelowShare, folders);
  Dl_info info{};
  if (dladdr(reinterpret_cast<void*>(&ComponentFolders), &info) != 0 && info.dli_fname != nullptr) {
    std::error_code error;
    const path library = std::filesystem::canonical(info.dli_fname, error);
    // PREFIX/lib/libhgros.so, or PREFIX/lib/x86_64-linux-gnu/libhgros.so.
    for (path above = library.parent_path(); !error && above.has_relative_path(); above = above.parent_path()) {
      if (above.filename() == "lib") folders.push_back(above.parent_path() / "share" / kBelowShare);
    }
  }
  AddFolders("XDG_DATA_DIRS", "/usr/local/share:/usr/share", kBelowShare, folders);
  std::vector<path> distinct;
  for (const path& one : folders) {
    if (std::ranges::find(distinct, one) == distinct.end()) distinct.push_back(one);
  }
  return distinct;
}

ComponentCatalog::ComponentCatalog(std::vector<path> folders) : folders_(std::move(folders)) {
  for (const path& folder : folders_) {
    std::vector<path> manifests;
    std::error_code error;
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
      std::error_code broken;  // Of a link.
      if (at->path().extension() == ".yaml" && at->is_regular_file(broken)) manifests.push_back(at->path());
    }
    if (error && error != std::errc::no_such_file_or_directory) {
      faults_.push_back("The folder " + folder.string() + " cannot be read: " + error.message() + ".");
    }
    std::ranges::sort(manifests);
    for (const path& one : manifests) {
      try {
        Read(one);
      } catch (const std::exception& fault) {
        faults_.emplace_back(fault.what());
      }
    }
  }
}

void ComponentCatalog::Read(const path& manifest) {
  const yaml::Document document = yaml::Document::Load(manifest);
  const yaml::Section section(yaml::Value(document), "a map with library, and components or language",
                              {"library", "components", "language"});
  ComponentLibrary library{manifest, path(section.Require("library").Text("the path of a shared library")), {}};
  if (library.file.is_relative()) library.file = manifest.parent_path() / library.file;
  library.file = std::filesystem::absolute(library.file).lexically_normal();
  if (const auto language = section.Find("language")) {
    library.language = language->Text("the name of a language");
  } else {
    for (const yaml::Value& type : section.Require("components").List("a list of component types")) {
      library.types.push_back(type.Text("the name of a component type"));
    }
  }
  std::ranges::sort(library.types);
  libraries_.push_back(std::move(library));
}

const ComponentLibrary& ComponentCatalog::Find(std::string_view type) const {
  std::vector<std::string> all;
  for (const ComponentLibrary& one : libraries_) {
    if (std::ranges::find(one.types, type) != one.types.end()) return one;
    all.insert(all.end(), one.types.begin(), one.types.end());
  }
  std::string mend;
  if (type.find(':') != std::string_view::npos) {
    const auto python = std::ranges::find(libraries_, "python", &ComponentLibrary::language);
    if (python != libraries_.end()) return *python;
    mend =
        "It is a class of Python, and hgros is installed without Python here. Install python3-dev and pybind11-dev, "
        "and build it again; or name the folder of python.yaml in HGROS_COMPONENT_PATH.";
  } else if (const std::string nearest = NearestName(type, all); !nearest.empty()) {
    mend = "Did you mean \"" + nearest + "\"?";
  } else {
    mend = "Install its library, or name the folder of its manifest in HGROS_COMPONENT_PATH. Looked in:";
    for (const path& folder : folders_) mend += (folder == folders_.front() ? " " : ", ") + folder.string();
    mend += ".";
  }
  for (const std::string& fault : faults_) mend += " " + fault;
  throw Error("There is no component type \"" + std::string(type) + "\".", {}, mend);
}

const ComponentType& ComponentCatalog::Load(std::string_view type) const {
  const std::vector<std::string> known = ComponentTypeNames();
  if (std::ranges::find(known, type) == known.end()) {
    const ComponentLibrary& library = Find(type);
    const std::vector<std::string> loaded = LoadComponents(library.file);
    if (library.language.empty() && std::ranges::find(loaded, type) == loaded.end()) {
      throw Error("The library " + library.file.string() + " has no component type \"" + std::string(type) + "\".",
                  library.manifest.string(), "Build and install it again.");
    }
  }
  return FindComponentType(type);
}

}  // namespace hgros

// The component types that the process knows, and the shared libraries that bring them.
#include <dlfcn.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/codec/run_time_type.hpp"
#include "hgros/component/component.hpp"

namespace hgros {
namespace {

// Thread safety: mutex guards the rest.
struct KnownTypes {
  std::mutex mutex;
  std::map<std::string, ComponentType, std::less<>> types;  // Entries stay.
  std::map<std::string, std::string, std::less<>> faults;   // Names that cannot be used, and why.
  ComponentFinder finder = nullptr;
};

// Never destroyed: libraries may register while the process ends.
KnownTypes& Known() {
  static auto& known = *new KnownTypes;
  return known;
}

// The file that a function is in.
template <class Function>
std::string FileOf(Function* function) {
  Dl_info info{};
  if (dladdr(reinterpret_cast<void*>(function), &info) == 0 || info.dli_fname == nullptr) return "the program";
  return info.dli_fname;
}
std::string FileOf(const ComponentType& type) { return FileOf(type.construct); }

bool IsSameFile(const std::string& one, const std::string& other) {
  std::error_code error;
  return std::filesystem::equivalent(one, other, error);
}

}  // namespace

bool RegisterComponent(ComponentType type) noexcept {
  KnownTypes& known = Known();
  const std::scoped_lock lock(known.mutex);
  const auto [at, added] = known.types.try_emplace(type.name, type);
  if (!added && at->second.construct != type.construct) {
    known.faults[type.name] = "Two component types are named \"" + type.name + "\": in " + FileOf(at->second) +
                              " and in " + FileOf(type) + ".";
  } else if (const std::string fault = ChannelNameFault(type.name); !fault.empty()) {
    known.faults[type.name] = "\"" + type.name + "\" cannot be the name of a component type: " + fault + ".";
  }
  return true;
}

bool RegisterComponentFinder(ComponentFinder finder) noexcept {
  KnownTypes& known = Known();
  const std::scoped_lock lock(known.mutex);
  known.finder = finder;
  return true;
}

const TypeInfo& RawStateType(const MessageSchema& schema) { return RunTimeType(schema); }

const ComponentType& FindComponentType(std::string_view name) {
  KnownTypes& known = Known();
  std::unique_lock lock(known.mutex);
  if (known.finder != nullptr && name.find(':') != std::string_view::npos && !known.types.contains(name)) {
    const ComponentFinder find = known.finder;
    lock.unlock();  // It may take long, and register other types.
    ComponentType found = find(name);
    lock.lock();
    return known.types.try_emplace(std::string(name), std::move(found)).first->second;
  }
  if (const auto fault = known.faults.find(name); fault != known.faults.end()) {
    throw Error(fault->second, {}, "Rename one of them in its HGROS_COMPONENT.");
  }
  if (const auto found = known.types.find(name); found != known.types.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [one, type] : known.types) names.push_back(one);
  const std::string nearest = NearestName(name, names);
  throw Error("There is no component type \"" + std::string(name) + "\".", {},
              nearest.empty() ? "Build a library with HGROS_COMPONENT(..., \"" + std::string(name) + "\")."
                              : "Did you mean \"" + nearest + "\"?");
}

std::vector<std::string> ComponentTypeNames() {
  KnownTypes& known = Known();
  const std::scoped_lock lock(known.mutex);
  std::vector<std::string> names;
  for (const auto& [name, type] : known.types) names.push_back(name);
  return names;
}

std::vector<std::string> LoadComponents(const std::filesystem::path& library) {
  // A path with a slash, so that dlopen does not search its own folders.
  const std::string path = std::filesystem::absolute(library).string();
  void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (handle == nullptr) {
    const char* fault = dlerror();
    throw Error("The library " + path + " cannot be loaded.", {}, fault == nullptr ? "" : std::string(fault) + ".");
  }
  std::vector<std::string> names;
  KnownTypes& known = Known();
  const std::scoped_lock lock(known.mutex);
  for (const auto& [name, type] : known.types) {
    if (IsSameFile(FileOf(type), path)) names.push_back(name);
  }
  dlclose(handle);  // RTLD_NODELETE: it stays.
  if (names.empty() && !(known.finder != nullptr && IsSameFile(FileOf(known.finder), path))) {
    throw Error("The library " + path + " has no component.", {},
                "Add HGROS_COMPONENT(Class, \"package/Name\") to it.");
  }
  return names;
}

}  // namespace hgros

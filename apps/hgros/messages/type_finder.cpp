#include "messages/type_finder.hpp"

#include <google/protobuf/compiler/importer.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor_database.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/codec/schema.hpp"

namespace hgros::cli {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::DescriptorPool;
using google::protobuf::FileDescriptor;
using google::protobuf::compiler::DiskSourceTree;
using std::filesystem::path;

// Keeps the first fault. What follows is usually its consequence.
class FirstFault : public google::protobuf::compiler::MultiFileErrorCollector {
 public:
  explicit FirstFault(DiskSourceTree& tree) : tree_(tree) {}
  void AddError(const std::string& file, int line, int column, const std::string& message) override {
    if (fault) return;
    std::string on_disk = file;
    (void)tree_.VirtualFileToDiskFile(file, &on_disk);
    fault.emplace(message + (message.ends_with('.') ? "" : "."), FilePosition{on_disk, line + 1, column + 1});
  }

  std::optional<ConfigError> fault;

 private:
  DiskSourceTree& tree_;
};

void AddNames(const Descriptor& type, std::vector<std::string>& names) {
  names.push_back(type.full_name());
  for (int i = 0; i < type.nested_type_count(); ++i) {
    if (!type.nested_type(i)->options().map_entry()) AddNames(*type.nested_type(i), names);
  }
}

// The folder of an installed hgros; empty in the folder of a build, where the library's types are compiled in as well.
path InstalledFolder() {
  std::error_code failed;
  const path program = std::filesystem::read_symlink("/proc/self/exe", failed);
  const path folder = (program.parent_path() / HGROS_PROTO_FROM_PROGRAM).lexically_normal();
  return !failed && std::filesystem::is_directory(folder, failed) ? folder : path();
}

}  // namespace

struct TypeFinder::Parts {
  DiskSourceTree tree;
  google::protobuf::DescriptorPoolDatabase compiled{*DescriptorPool::generated_pool()};
  google::protobuf::compiler::SourceTreeDescriptorDatabase database{&tree, &compiled};
  FirstFault faults{tree};
  DescriptorPool pool{&database, database.GetValidationErrorCollector()};
  std::vector<std::string> names;

  Parts() {
    database.RecordErrorsTo(&faults);
    pool.EnforceWeakDependencies(true);
  }
  // `name` as files import it.
  const FileDescriptor& Read(const std::string& name) {
    const FileDescriptor* file = pool.FindFileByName(name);
    if (file == nullptr) {
      if (faults.fault) throw ConfigError(*faults.fault);
      throw ConfigError("The file cannot be read.", {name, 0, 0});
    }
    for (int i = 0; i < file->message_type_count(); ++i) AddNames(*file->message_type(i), names);
    return *file;
  }
};

void TypeOptions::Declare(Arguments& arguments) {
  arguments.Option("--proto", "FILE", files, "Take types from this .proto file; may be repeated", ValueKind::kFile);
  arguments.Option("-I,--import", "DIR", folders, "Find imported .proto files below this folder; may be repeated",
                   ValueKind::kFile);
}

TypeFinder::TypeFinder(const TypeOptions& options) : parts_(std::make_unique<Parts>()) {
  for (const std::string& folder : options.folders) {
    if (!std::filesystem::is_directory(folder)) throw UsageError("-I: there is no folder " + folder + ".");
    parts_->tree.MapPath("", folder);
  }
  std::vector<std::string> names;
  for (const std::string& file : options.files) {
    if (std::filesystem::is_directory(file)) {
      throw UsageError("--proto: " + file + " is a folder. Name a .proto file, or give the folder with -I.");
    }
    if (!std::filesystem::is_regular_file(file)) throw UsageError("--proto: there is no file " + file + ".");
    std::string name;
    std::string other;
    if (parts_->tree.DiskFileToVirtualFile(file, &name, &other) != DiskSourceTree::SUCCESS) {
      const path folder = path(file).parent_path();
      parts_->tree.MapPath("", folder.empty() ? "." : folder.string());
      if (parts_->tree.DiskFileToVirtualFile(file, &name, &other) != DiskSourceTree::SUCCESS) {
        throw UsageError("--proto: another file has the same name as " + file + ". Give their common folder with -I.");
      }
    }
    names.push_back(name);
  }
  if (const path installed = InstalledFolder(); !installed.empty()) parts_->tree.MapPath("", installed.string());
  for (const std::string& name : names) (void)parts_->Read(name);
}

TypeFinder::~TypeFinder() = default;

const Descriptor* TypeFinder::Find(const std::string& given) const {
  std::string name = given;
  std::ranges::replace(name, '/', '.');
  if (const Descriptor* type = parts_->pool.FindMessageTypeByName(name)) return type;
  // a.b.C is expected in a/b/C.proto, a.b.C.D too.
  for (std::string part = name; !part.empty(); part.resize(std::min(part.find_last_of('.'), part.size()))) {
    std::string file = part;
    std::ranges::replace(file, '.', '/');
    std::string on_disk;
    if (parts_->tree.VirtualFileToDiskFile(file + ".proto", &on_disk)) {
      (void)parts_->Read(file + ".proto");
      if (const Descriptor* type = parts_->pool.FindMessageTypeByName(name)) return type;
    }
    if (part.find('.') == std::string::npos) break;
  }
  return DescriptorPool::generated_pool()->FindMessageTypeByName(name);
}

const Descriptor& TypeFinder::Require(const std::string& name) const {
  if (const Descriptor* type = Find(name)) return *type;
  const std::string nearest = Nearest(name);
  throw UsageError("The type " + name + " is not known." +
                   (nearest.empty() ? " Give its file with --proto, or the folder of its file with -I."
                                    : " Did you mean " + nearest + "?"));
}

std::string TypeFinder::Nearest(const std::string& name) const {
  std::vector<std::string> names;
  DescriptorPool::internal_generated_database()->FindAllMessageNames(&names);
  std::erase_if(names, [](const std::string& one) { return one.starts_with("hgros.wire."); });
  names.insert(names.begin(), parts_->names.begin(), parts_->names.end());
  for (const std::string& one : names) {
    if (one.ends_with("." + name)) return one;
  }
  return NearestName(name, names);
}

MessageSchema SchemaFor(const Descriptor& type) {
  return {type.full_name(), Encoding::kProtobuf, SchemaFingerprint(type), DescriptorSet(type)};
}

}  // namespace hgros::cli

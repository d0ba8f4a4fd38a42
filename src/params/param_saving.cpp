// The part of ParamServer::Core that writes files.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "hgros/yaml/document.hpp"
#include "params/param_server_core.hpp"
#include "params/replaced_file.hpp"
#include "params/yaml_edit.hpp"

namespace hgros {
namespace {

// Collects the values that were set while running. Maps are split into their keys; a list is one value, even if only a
// part of it changed.
void CollectSet(const ParamPath& path, const ParamNodePtr& node, std::vector<YamlEdit>& edits) {
  if (node->kind == ParamNode::Kind::kMap && !node->entries.empty()) {
    for (const auto& [key, value] : node->entries) CollectSet(path.Below(key), value, edits);
  } else if (node->origin.at_run_time) {
    edits.push_back({path, node});
  }
}

std::string ReadText(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

void ParamServer::Core::Save() {
  const std::scoped_lock files(files_mutex_);
  if (sources_.files.empty()) {
    throw Error("The parameters come from no file, so there is no file to save them in.", {}, "Use SaveAs().");
  }
  std::vector<YamlEdit> edits;
  CollectSet({}, root(), edits);

  std::vector<ParamNodePtr> said;
  for (const std::filesystem::path& file : sources_.files) {
    said.push_back(param_tree::FromDocument(yaml::Document::Load(file)));
  }
  std::map<std::size_t, std::vector<YamlEdit>> by_file;
  for (YamlEdit& edit : edits) {
    std::size_t owner = sources_.files.size() - 1;
    for (std::size_t i = said.size(); i-- > 0;) {
      if (param_tree::Find(said[i], edit.path) == nullptr) continue;
      owner = i;
      break;
    }
    const ParamNodePtr there = param_tree::Find(said[owner], edit.path);
    if (there == nullptr || !there->SameValue(*edit.value)) by_file[owner].push_back(std::move(edit));
  }
  for (const auto& [index, of_file] : by_file) {
    const std::filesystem::path& file = sources_.files[index];
    const EditedYaml edited = EditYaml(ReadText(file), file.string(), of_file);
    if (!edited.comments_kept) {
      log_.Write(LogLevel::kWarning, "The comments in " + file.string() +
                                         " are lost: with its layout there was no other way to save the changed "
                                         "values.");
    }
    ReplaceFile(file, edited.text);
  }
  if (!by_file.empty()) loaded_ = ReadSources();
}

void ParamServer::Core::SaveAs(const std::filesystem::path& file) const {
  ReplaceFile(file, WrittenYaml(root(), file.string()));
}

}  // namespace hgros

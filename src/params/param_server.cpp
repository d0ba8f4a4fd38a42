#include "hgros/params/param_server.hpp"

#include <algorithm>
#include <utility>

#include "params/param_server_core.hpp"

namespace hgros {

bool ParamEvent::Touches(const ParamPath& path) const {
  return std::any_of(paths.begin(), paths.end(), [&](const ParamPath& changed) { return changed.Overlaps(path); });
}

ParamServer::ParamServer(ParamSources sources, LogSink log)
    : core_(std::make_shared<Core>(std::move(sources), std::move(log))) {}
ParamServer::~ParamServer() {
  if (core_->fork.IsChild()) LeaveToParent(std::move(core_));
}

ParamView ParamServer::Snapshot() const { return ParamView(core_->root()); }

ParamView ParamServer::DeclareNode(std::string_view path, ParamNode fallback, ParamInfo info, TypeCheck check) {
  const ParamOrigin origin{std::make_shared<const std::string>("the default of " + std::string(path))};
  ParamPath parsed = ParamPath::Parse(path);
  const ParamNodePtr root =
      core_->Declare({parsed, param_tree::WithOrigin(fallback, origin), std::move(info), std::move(check)});
  return ParamView(root).At(parsed);
}

std::vector<ParamDeclaration> ParamServer::Declarations() const { return core_->Declarations(); }

ParamResult ParamServer::Change(const std::vector<ParamChange>& changes, IfMissing if_missing) {
  const auto source = std::make_shared<const std::string>("set while running");
  std::vector<Core::Step> steps;
  try {
    for (const ParamChange& change : changes) {
      ParamNodePtr value;
      if (change.value) value = param_tree::WithOrigin(*change.value, {source, 0, 0, true});
      steps.push_back({ParamPath::Parse(change.path), std::move(value)});
    }
  } catch (const ParamError& e) {
    return {e.what()};
  }
  return core_->Change(steps, if_missing);
}

Listening ParamServer::AddValidator(std::string_view path, ParamValidator validator) {
  return core_->AddValidator(ParamPath::Parse(path), std::move(validator));
}

Listening ParamServer::OnChange(std::string_view path, ParamListener listener) {
  return core_->OnChange(ParamPath::Parse(path), std::move(listener));
}

void ParamServer::Save() { core_->Save(); }
void ParamServer::SaveAs(const std::filesystem::path& file) const { core_->SaveAs(file); }
ParamResult ParamServer::Reload() { return core_->Reload(); }
const std::vector<std::filesystem::path>& ParamServer::files() const noexcept { return core_->files(); }

}  // namespace hgros

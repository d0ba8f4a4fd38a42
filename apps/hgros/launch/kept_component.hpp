#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hgros/component/components.hpp"
#include "hgros/params/param_server.hpp"
#include "launch/run.pb.h"

namespace hgros::cli {

/// What of a component outlives its process, for the next instance.
struct KeptComponent {
  std::shared_ptr<const RawMessage> state = nullptr;  ///< Its last checkpoint.
  std::map<std::string, std::string> params = {};     ///< Those that were changed while it ran: path and YAML.

  void Note(const RunReport::Changed& changed);
  /// The setup of the next instance.
  [[nodiscard]] ComponentSetup Continue(ComponentSetup setup) const;
  /// Of its parameters, those that differ from `earlier`.
  [[nodiscard]] std::vector<ParamChange> ChangesSince(const KeptComponent& earlier) const;
};

/// By the names of components.
using KeptComponents = std::map<std::string, KeptComponent>;

/// The largest state. A message to the starter has at most 64 MiB.
inline constexpr std::size_t kMostStateBytes = 48U << 20U;

/// What the new place of a component gets from the old one, apart from the state.
void Write(const KeptComponent& kept, RunOrder::Move& move);
[[nodiscard]] KeptComponent KeptOf(const RunOrder::Move& move);

/// A state on its way to the starter, and there.
[[nodiscard]] RunReport ReportOf(const std::string& component, const RawMessage& state);
[[nodiscard]] std::shared_ptr<const RawMessage> StateOf(const RunReport::Saved& saved);

}  // namespace hgros::cli

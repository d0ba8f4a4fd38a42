#pragma once

#include <map>
#include <memory>
#include <string>

#include "hgros/component/components.hpp"
#include "launch/run.pb.h"

namespace hgros::cli {

/// What of a component outlives its process, for the next instance.
struct KeptComponent {
  std::shared_ptr<const RawMessage> state = nullptr;  ///< Its last checkpoint.
  std::map<std::string, std::string> params = {};     ///< Those that were changed while it ran: path and YAML.

  void Note(const RunReport::Changed& changed);
  /// The setup of the next instance.
  [[nodiscard]] ComponentSetup Continue(ComponentSetup setup) const;
};

/// By the names of components.
using KeptComponents = std::map<std::string, KeptComponent>;

/// A state on its way to the starter, and there.
[[nodiscard]] RunReport ReportOf(const std::string& component, const RawMessage& state);
[[nodiscard]] std::shared_ptr<const RawMessage> StateOf(const RunReport::Saved& saved);

}  // namespace hgros::cli

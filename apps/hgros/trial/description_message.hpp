#pragma once

#include "hgros/component/component_description.hpp"
#include "trial/trial.pb.h"

namespace hgros::cli {

/// A description as a process that constructs components tells it, and back.
[[nodiscard]] TrialStep::Made MessageOf(const ComponentDescription& description);
[[nodiscard]] ComponentDescription DescriptionFrom(const TrialStep::Made& made);

}  // namespace hgros::cli

#include "params/declared_params.hpp"

#include <algorithm>
#include <limits>

#include "hgros/base/names.hpp"
#include "hgros/yaml/scalar_text.hpp"
#include "params/param_tree.hpp"

namespace hgros {
namespace {

std::string RangeText(const ParamInfo& info) {
  const std::string unit = info.unit.empty() ? "" : " " + info.unit;
  if (!info.most) return "at least " + scalar::FromNumber(*info.least) + unit;
  if (!info.least) return "at most " + scalar::FromNumber(*info.most) + unit;
  return "from " + scalar::FromNumber(*info.least) + " to " + scalar::FromNumber(*info.most) + unit;
}

void RequireBounds(const ParamInfo& info, const ParamView& value) {
  const ParamNode& node = *value.node();
  if (node.kind == ParamNode::Kind::kList) {
    for (std::size_t i = 0; i < node.items.size(); ++i) RequireBounds(info, value[i]);
    return;
  }
  if (node.kind != ParamNode::Kind::kText) return;
  if (info.least || info.most) {
    const std::optional<double> plain = node.quoted ? std::nullopt : scalar::Number(node.text);
    const double number = plain ? *plain : std::chrono::duration<double>(params_detail::ReadDuration(value)).count();
    if (!(number >= info.least.value_or(number)) || !(number <= info.most.value_or(number)))
      value.FailType(RangeText(info));
  }
  if (!info.choices.empty()) (void)params_detail::ReadChoice(value, info.choices);
}

}  // namespace

std::string DeclaredParams::TypeOf(const Entry& entry) {
  const ParamNode& node = *entry.fallback;
  if (node.kind == ParamNode::Kind::kList) return "list";
  if (node.kind == ParamNode::Kind::kMap) return "map";
  if (node.kind != ParamNode::Kind::kText) return {};
  if (node.quoted) return "text";
  if (scalar::Boolean(node.text)) return "bool";
  if (scalar::Integer(node.text)) return "integer";
  if (scalar::Number(node.text)) return "number";
  try {
    (void)params_detail::ReadDuration(ParamView(entry.fallback, entry.path));
    return "duration";
  } catch (const ParamError&) {
    return "text";
  }
}

const DeclaredParams::Entry* DeclaredParams::Find(const ParamPath& path) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.path == path; });
  return found == entries_.end() ? nullptr : &*found;
}

ParamNodePtr DeclaredParams::WithFallbacks(ParamNodePtr root, const ParamPath& changed) const {
  for (const Entry& entry : entries_) {
    if (!entry.path.Overlaps(changed)) continue;
    if (param_tree::Find(root, entry.path) == nullptr) root = param_tree::With(root, entry.path, entry.fallback);
  }
  return root;
}

void DeclaredParams::RequireRange(const Entry& entry) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (entry.info.least.value_or(-kInfinity) <= entry.info.most.value_or(kInfinity)) return;  // A NaN is neither.
  throw ParamError("No value of " + entry.path.ToString() + " can be " + RangeText(entry.info) + ".", {},
                   "Correct its bounds.");
}

void DeclaredParams::RequireGood(const Entry& entry, const ParamView& value) {
  entry.check(value);
  RequireBounds(entry.info, value);
}

void DeclaredParams::RequireAllowed(const ParamEvent& event) const {
  for (const Entry& entry : entries_) {
    if (!event.Touches(entry.path)) continue;
    const ParamView value = event.after.At(entry.path);
    if (entry.info.read_only) {
      throw ParamError(entry.path.ToString() + " is read-only.", value.node()->origin.ToString(),
                       "Change it in a file or on the command line, and start again.");
    }
    RequireGood(entry, value);
  }
}

}  // namespace hgros

#include "hgros/params/param_codec.hpp"

#include <algorithm>
#include <cmath>

#include "hgros/base/names.hpp"
#include "hgros/yaml/scalar_text.hpp"

namespace hgros::params_detail {
namespace {

// The text of an unquoted scalar, or null.
const std::string* Plain(const ParamView& view) {
  const ParamNodePtr& node = view.node();
  return node != nullptr && node->kind == ParamNode::Kind::kText && !node->quoted ? &node->text : nullptr;
}

// Suggests to remove the quotes if `fits` accepts the text without them.
template <class Fits>
std::string_view WithoutQuotes(const ParamView& view, const Fits& fits) {
  const ParamNodePtr& node = view.node();
  const bool quoted = node != nullptr && node->kind == ParamNode::Kind::kText && node->quoted;
  return quoted && fits(node->text) ? "Write it without quotes." : "";
}

struct Unit {
  std::string_view name;
  double nanoseconds;
};
constexpr std::array kUnits{Unit{"ns", 1},  Unit{"us", 1e3},   Unit{"ms", 1e6},
                            Unit{"s", 1e9}, Unit{"min", 60e9}, Unit{"h", 3600e9}};

}  // namespace

bool ReadBoolean(const ParamView& view) {
  const std::string* const text = Plain(view);
  if (const auto value = text != nullptr ? scalar::Boolean(*text) : std::nullopt) return *value;
  view.FailType("true or false", WithoutQuotes(view, scalar::Boolean));
}

double ReadNumber(const ParamView& view) {
  const std::string* const text = Plain(view);
  if (const auto number = text != nullptr ? scalar::Number(*text) : std::nullopt) return *number;
  view.FailType("a number", WithoutQuotes(view, scalar::Number));
}

std::int64_t ReadInteger(const ParamView& view, std::int64_t least, std::int64_t most) {
  const std::string* const text = Plain(view);
  const auto number = text != nullptr ? scalar::Integer(*text) : std::nullopt;
  if (number && *number >= least && *number <= most) return *number;
  view.FailType("an integer from " + std::to_string(least) + " to " + std::to_string(most),
                WithoutQuotes(view, scalar::Integer));
}

std::uint64_t ReadUnsigned(const ParamView& view, std::uint64_t most) {
  const std::string* const text = Plain(view);
  const auto number = text != nullptr ? scalar::Unsigned(*text) : std::nullopt;
  if (number && *number <= most) return *number;
  view.FailType("an integer from 0 to " + std::to_string(most), WithoutQuotes(view, scalar::Unsigned));
}

std::string ReadText(const ParamView& view) {
  if (view.node() == nullptr || view.node()->kind != ParamNode::Kind::kText) view.FailType("a text");
  return view.node()->text;
}

std::chrono::nanoseconds ReadDuration(const ParamView& view) {
  constexpr std::string_view kWanted = "a duration such as 250ms or 1.5s, or a number of seconds";
  if (view.node() == nullptr || view.node()->kind != ParamNode::Kind::kText) view.FailType(kWanted);
  const std::string_view text = view.node()->text;
  const std::size_t letters = std::min(text.find_last_of("0123456789.") + 1, text.size());
  std::string_view unit = text.substr(letters);
  while (unit.starts_with(' ')) unit.remove_prefix(1);
  if (unit.empty() && !view.node()->quoted) unit = "s";
  const auto known = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.name == unit; });
  if (known == kUnits.end()) view.FailType(kWanted);
  const std::string_view digits = text.substr(0, letters);
  if (const auto whole = scalar::Integer(digits)) {
    std::int64_t nanoseconds = 0;
    if (!__builtin_mul_overflow(*whole, static_cast<std::int64_t>(known->nanoseconds), &nanoseconds)) {
      return std::chrono::nanoseconds(nanoseconds);
    }
  }
  const auto number = scalar::Number(digits);
  const double nanoseconds = number.value_or(NAN) * known->nanoseconds;
  if (!(std::abs(nanoseconds) < 9.2e18)) view.FailType(kWanted);
  return std::chrono::nanoseconds(std::llround(nanoseconds));
}

std::size_t ReadChoice(const ParamView& view, const std::vector<std::string>& names) {
  std::string wanted = "one of ";
  for (const std::string& name : names) wanted += (&name == names.data() ? "" : ", ") + name;
  if (view.node() == nullptr || view.node()->kind != ParamNode::Kind::kText) view.FailType(wanted);
  const std::string& text = view.node()->text;
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  const std::string nearest = text.size() <= 64 ? NearestName(text, names) : std::string();
  view.FailType(wanted, nearest.empty() ? "" : "Did you mean \"" + nearest + "\"?");
}

ParamNode WriteNumber(double number) { return ParamNode::Text(scalar::FromNumber(number), false); }

ParamNode WriteDuration(std::chrono::nanoseconds duration) {
  for (auto unit = kUnits.rbegin(); unit != kUnits.rend(); ++unit) {
    const auto size = static_cast<std::int64_t>(unit->nanoseconds);
    if (duration.count() % size == 0 && (duration.count() != 0 || unit->name == "s")) {
      return ParamNode::Text(std::to_string(duration.count() / size) + std::string(unit->name), false);
    }
  }
  return ParamNode::Text("0s", false);
}

}  // namespace hgros::params_detail

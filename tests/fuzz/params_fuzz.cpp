// Parameter files and overrides may be any text. They are accepted, or refused with ParamError or ConfigError, in
// bounded time. An accepted file can be written and read again, and after an edit it has the wanted value. The input
// consists of a file, a path and a value, separated by lines "=".
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "hgros/base/error.hpp"
#include "params/param_tree.hpp"
#include "params/yaml_edit.hpp"

namespace {

void Require(bool condition) {
  if (!condition) std::abort();
}

hgros::ParamNodePtr Parsed(const std::string& text) {
  return hgros::param_tree::FromDocument(hgros::yaml::Document::Parse(text, "fuzz"));
}

std::string_view TakePart(std::string_view& rest) {
  constexpr std::string_view kMark = "\n=\n";
  const std::size_t at = rest.find(kMark);
  const std::string_view part = rest.substr(0, at);
  rest.remove_prefix(at == std::string_view::npos ? rest.size() : at + kMark.size());
  return part;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  const std::string file(TakePart(rest));
  const std::string_view path_text = TakePart(rest);
  try {
    const hgros::ParamNodePtr root = Parsed(file);
    Require(Parsed(hgros::WrittenYaml(root, "fuzz"))->SameValue(*root));
    const hgros::ParamPath path = hgros::ParamPath::Parse(path_text);
    Require(hgros::ParamPath::Parse(path.ToString()) == path);
    const hgros::ParamNodePtr value = hgros::param_tree::FromValue(rest, {});
    const hgros::ParamNodePtr wanted = hgros::param_tree::With(root, path, value);
    for (const hgros::ParamPath::Step& step : path.steps()) {
      if (!std::holds_alternative<std::string>(step)) return 0;
    }
    if (path.empty()) return 0;
    Require(Parsed(hgros::EditYaml(file, "fuzz", {{path, value}}).text)->SameValue(*wanted));
  } catch (const hgros::Error& error) {
    Require(*error.what() != '\0');
  }
  return 0;
}

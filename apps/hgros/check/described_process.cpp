#include "check/described_process.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "check/config_schema.hpp"
#include "hgros/base/names.hpp"
#include "hgros/config/check.hpp"
#include "terminal/json.hpp"

namespace hgros::cli {
namespace {

using yaml::Document;
using yaml::Node;

const Node* Find(const Node& map, std::string_view key) {
  if (map.kind != Node::Kind::kMap) return nullptr;
  const auto entry =
      std::ranges::find(map.entries, key, [](const Node::Entry& one) -> const std::string& { return one.key->text; });
  return entry == map.entries.end() ? nullptr : entry->value;
}

const Node* FindBelow(const Node& map, std::initializer_list<std::string_view> keys) {
  const Node* node = &map;
  for (const std::string_view key : keys) {
    if (node != nullptr) node = Find(*node, key);
  }
  return node;
}

// The spelling of EndpointConfig; empty: the endpoint is off. `ip` was read without a fault before.
std::string Normalized(const std::string& ip, bool publisher) {
  Json json;
  json.Value(ip);
  const std::string one = "{ip: " + std::string(json.text()) + "}";
  const Config config =
      Config::Parse(publisher ? "network: {publisher: " + one + "}" : "network: {subscribers: [" + one + "]}");
  const auto& side = publisher ? config.publishers : config.subscribers;
  return side.empty() ? std::string() : side.front().endpoint;
}

void AddEndpoint(const Document& document, const Node& node, bool publisher, std::vector<DescribedEndpoint>& side) {
  const Node* ip = Find(node, "ip");
  const std::string text = ip == nullptr ? std::string() : Normalized(ip->text, publisher);
  if (text.empty()) return;
  auto endpoint = std::ranges::find(side, text, &DescribedEndpoint::text);
  const Node* list = Find(node, "channels");
  if (endpoint == side.end()) {
    const FilePosition at = document.PositionOf(*ip);
    endpoint = side.insert(side.end(), {text, at, list == nullptr ? at : document.PositionOf(*list)});
  }
  if (list == nullptr) {
    endpoint->all_channels = true;
    return;
  }
  for (const Node* channel : list->items) endpoint->channels.emplace(channel->text, document.PositionOf(*channel));
}

void AddEndpoints(const Document& document, DescribedProcess& process) {
  if (const Node* publisher = FindBelow(document.root(), {"network", "publisher"})) {
    if (publisher->kind == Node::Kind::kMap) AddEndpoint(document, *publisher, true, process.publishers);
    for (const Node* one : publisher->items) AddEndpoint(document, *one, true, process.publishers);
  }
  if (const Node* subscribers = FindBelow(document.root(), {"network", "subscribers"})) {
    for (const Node* one : subscribers->items) AddEndpoint(document, *one, false, process.subscribers);
  }
}

// Programs name their sections without spaces, those of Unicode included: a key with one is a mistake.
bool MayBeOfProgram(std::string_view key) {
  constexpr std::string_view kNoBreakSpace = "\u00a0";
  constexpr std::string_view kOtherSpaces = "\xe2\x80";  // U+2000 to U+203F
  return std::ranges::none_of(key, [](char c) { return static_cast<unsigned char>(c) <= 0x20 || c == 0x7f; }) &&
         key.find(kNoBreakSpace) == std::string_view::npos && key.find(kOtherSpaces) == std::string_view::npos;
}

void AddProgramSections(const Document& document, std::vector<std::string>& sections, FileFindings& findings) {
  const std::vector<std::string> known = ConfigSections();
  for (const Node::Entry& entry : document.root().entries) {
    const std::string& key = entry.key->text;
    if (std::ranges::find(known, key) != known.end() || !NearestName(key, known).empty() || !MayBeOfProgram(key)) {
      continue;
    }
    findings.push_back({Severity::kNote, "section", document.PositionOf(*entry.key),
                        "\"" + key + "\" is taken for a section of the program's own.",
                        "Give --section " + key + " to allow only sections that are named."});
    if (std::ranges::find(sections, key) == sections.end()) sections.push_back(key);
  }
}

bool HasItsKeyFile(const Document& document) {
  const Node* file = FindBelow(document.root(), {"network", "security", "secret_key_file"});
  if (file == nullptr || file->kind != Node::Kind::kText) return true;
  std::error_code error;
  return std::filesystem::exists(std::filesystem::path(document.name()).parent_path() / file->text, error);
}

}  // namespace

bool PassesAny(const std::vector<DescribedEndpoint>& endpoints, std::string_view channel) {
  return std::ranges::any_of(endpoints, [channel](const DescribedEndpoint& one) { return one.Passes(channel); });
}

FileFinding FindingOf(const ConfigError& fault) {
  return {Severity::kFault, "file", FilePosition::From(fault.where()), fault.sentence(), fault.mend()};
}

FilePosition DescribedProcess::PlaceOf(std::initializer_list<std::string_view> keys) const {
  for (const Document& document : documents) {
    if (const Node* node = FindBelow(document.root(), keys)) return document.PositionOf(*node);
  }
  return {documents.front().name(), 1, 1};
}

std::vector<std::filesystem::path> FilesOf(const std::string& text) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  std::size_t begin = 0;
  if (std::filesystem::exists(text, error)) begin = text.size();
  if (begin > 0) files.emplace_back(text);
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('+', begin), text.size());
    files.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return files;
}

std::optional<DescribedProcess> ReadProcess(const std::string& files, const std::vector<std::string>& sections,
                                            FileFindings& findings) {
  DescribedProcess process;
  process.name = files;
  const std::vector<std::filesystem::path> paths = FilesOf(files);
  ConfigCheckOptions options{sections};
  for (const std::filesystem::path& path : paths) {
    try {
      const Document& document = process.documents.emplace_back(Document::Load(path));
      if (sections.empty()) AddProgramSections(document, options.program_sections, findings);
      options.read_key_files = options.read_key_files && HasItsKeyFile(document);
    } catch (const ConfigError&) {
      // CheckConfig() tells it.
    }
  }
  const CheckedConfig checked = CheckConfig(paths, options);
  for (const ConfigError& fault : checked.faults) findings.push_back(FindingOf(fault));
  if (!checked.faults.empty() || process.documents.empty()) return std::nullopt;
  if (!options.read_key_files) {
    findings.push_back({Severity::kNote, "key", process.PlaceOf({"network", "security", "secret_key_file"}),
                        "The key file is not on this host, so it is not compared with the public key.", ""});
  }
  process.config = checked.config;
  for (const Document& document : process.documents) AddEndpoints(document, process);
  return process;
}

}  // namespace hgros::cli

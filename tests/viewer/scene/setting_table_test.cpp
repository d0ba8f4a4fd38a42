#include <algorithm>
#include <fstream>
#include <map>
#include <vector>

#include "support/path.hpp"
#include "viewer/scene/scene_fixture.hpp"

namespace hgros::viewer::test {
namespace {

using Table = std::map<std::string, std::map<std::string, std::string>>;  ///< Display, setting: the default.

std::vector<std::string> Split(const std::string& text, const std::string& by) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(by, begin);
    std::string part = text.substr(begin, end == std::string::npos ? end : end - begin);
    part.erase(0, part.find_first_not_of(" `"));
    part.erase(part.find_last_not_of(" `") + 1);
    parts.push_back(part);
    if (end == std::string::npos) return parts;
    begin = end + by.size();
  }
}

/// The table of docs/viewer.md whose head is "display, setting, means, default".
Table ReadTable() {
  std::ifstream file(hgros::test::Path("page"));
  Table table;
  std::vector<std::string> displays;
  std::string line;
  while (std::getline(file, line) && line != "| display | setting | means | default |") {
  }
  std::getline(file, line);  // Between the head and the rows.
  while (std::getline(file, line) && !line.empty()) {
    const std::vector<std::string> cells = Split(line, "|");
    if (cells.size() != 6) {
      ADD_FAILURE() << line;
      continue;
    }
    if (!cells[1].empty()) displays = Split(cells[1], ", ");
    const std::vector<std::string> names = Split(cells[2], "`, `");
    const std::vector<std::string> defaults = Split(cells[4], ", ");
    EXPECT_EQ(names.size(), defaults.size()) << line;
    for (const std::string& display : displays) {
      for (std::size_t i = 0; i < std::min(names.size(), defaults.size()); ++i) {
        table[display][names[i]] = defaults[i] == "empty" ? "" : defaults[i];
      }
    }
  }
  return table;
}

class SettingTable : public SceneTest {};

TEST_F(SettingTable, OfTheManualMatchesAllSettingsAndDefaults) {
  Table table = ReadTable();
  int made = 0;
  for (const DisplayType& type : DisplayTypes()) {
    Display& display = Add(type.name, type.schemas.empty() ? "" : "channel_" + std::to_string(++made));
    auto& documented = table[type.name];
    for (const Setting& setting : display.Settings()) {
      const auto found = documented.find(setting.name);
      if (found == documented.end()) {
        ADD_FAILURE() << type.name << " has " << setting.name << ", which is not in docs/viewer.md.";
        continue;
      }
      const std::string text = found->second == "its own" ? TextOf(setting) : found->second;
      EXPECT_EQ(text, TextOf(setting)) << type.name << ": " << setting.name;
      documented.erase(found);
    }
    for (const auto& [name, text] : documented) ADD_FAILURE() << type.name << " has no " << name;
    table.erase(type.name);
  }
  for (const auto& [name, settings] : table) ADD_FAILURE() << "There is no display " << name;
}

}  // namespace
}  // namespace hgros::viewer::test

#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "check/file_finding.hpp"
#include "hgros/config/config.hpp"
#include "hgros/yaml/document.hpp"

namespace hgros::cli {

/// An endpoint of a process, from all of its files.
struct DescribedEndpoint {
  std::string text;  ///< In the spelling of EndpointConfig.
  FilePosition at;
  FilePosition list;  ///< Where its channels begin, or the same as `at`.
  bool all_channels = false;
  std::map<std::string, FilePosition, std::less<>> channels = {};

  [[nodiscard]] bool Passes(std::string_view channel) const { return all_channels || channels.contains(channel); }
};

/// Whether one of the endpoints lets the channel pass.
[[nodiscard]] bool PassesAny(const std::vector<DescribedEndpoint>& endpoints, std::string_view channel);

/// What the configuration files of one process say.
struct DescribedProcess {
  std::string name;  ///< Its files, as the user wrote them.
  std::vector<yaml::Document> documents;
  Config config;
  std::vector<DescribedEndpoint> publishers;
  std::vector<DescribedEndpoint> subscribers;

  /// The value at this path of keys, in the first file that has it; otherwise the beginning of the first file.
  [[nodiscard]] FilePosition PlaceOf(std::initializer_list<std::string_view> keys) const;
};

/// The sentence of an error without its place and its mend.
[[nodiscard]] FileFinding FindingOf(const ConfigError& fault);

/// The file names of one process: FILE, or FILE+FILE for a process that loads several.
[[nodiscard]] std::vector<std::filesystem::path> FilesOf(const std::string& text);

/// Reads the files of a process as strictly as the library. What is wrong is added to the findings; then the result is
/// empty. Without `sections`, keys at the top of a file that are not similar to a section of the library are taken for
/// sections of the program.
[[nodiscard]] std::optional<DescribedProcess> ReadProcess(const std::string& files,
                                                          const std::vector<std::string>& sections,
                                                          FileFindings& findings);

}  // namespace hgros::cli

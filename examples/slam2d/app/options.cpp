#include "options.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <hgros/base/names.hpp>
#include <hgros/params/param_codec.hpp>

#include "ending.hpp"
#include "parameters.hpp"

namespace slam2d {
namespace {

// CLI11 takes the next word for the value.
std::string NoOption(const std::string& text) {
  return text.starts_with("--") ? "needs a value, but the option " + text + " follows." : std::string();
}

// CLI11's own checks mention the limits of double.
std::string WholeNumberFromOne(const std::string& text) {
  if (std::string fault = NoOption(text); !fault.empty()) return fault;
  const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  if (digits && text.find_first_not_of('0') != std::string::npos && text.size() <= 9) return {};
  return "must be a whole number from 1 to 999999999, but is \"" + text + "\".";
}

std::string RateOrNothing(const std::string& text) {
  if (std::string fault = NoOption(text); !fault.empty()) return fault;
  double rate = -1;
  if (CLI::detail::lexical_cast(text, rate) && rate >= 0 && rate <= 1e6) return {};
  return "must be a number from 0 to 1000000, but is \"" + text + "\".";
}

std::string Assignment(const std::string& text) {
  if (std::string fault = NoOption(text); !fault.empty()) return fault;
  const std::size_t equals = text.find('=');
  if (equals != std::string::npos && equals > 0 && equals + 1 < text.size()) return {};
  return "must be PATH=VALUE, as in slam.matcher.max_range_m=20, but is \"" + text + "\".";
}

std::string UnknownOption(const CLI::App& app) {
  const std::vector<std::string> unknown = app.remaining();
  const auto option =
      std::find_if(unknown.begin(), unknown.end(), [](const std::string& text) { return text.starts_with("-"); });
  if (option == unknown.end()) return "\"" + unknown.front() + "\" does not belong to an option.";
  const std::string name = option->substr(0, option->find('='));
  std::vector<std::string> known;
  for (const CLI::Option* one : app.get_options()) known.push_back("--" + one->get_single_name());
  const std::string nearest = hgros::NearestName(name, known);
  return "There is no option " + name + "." + (nearest.empty() ? std::string() : " Did you mean " + nearest + "?");
}

// CLI11 prints "--scans: what is wrong". This makes a sentence that names the fix.
std::string Sentence(const CLI::App& app, const CLI::ParseError& error) {
  const std::string what = error.what();
  const std::string option = what.substr(0, what.find(':'));
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) return UnknownOption(app);
  if (error.get_name() == "ValidationError" && option.size() < what.size())
    return option + what.substr(option.size() + 1);
  if (error.get_name() == "ArgumentMismatch") {
    return option +
           (what.find("At Most") == std::string::npos ? " needs a value after it." : " may be given only once.");
  }
  return what + ".";
}

}  // namespace

std::variant<Options, int> ReadCommandLine(int argc, char** argv) {
  Options options;
  int patience_s = static_cast<int>(options.patience.count());
  std::vector<std::string> set_params;
  std::vector<std::string> taken_before;
  CLI::App app{"2D laser SLAM as a hypergraph of nodes: source, matcher, mapper, writer."};
  app.footer(
      "Without --log the robot drives through a simulated building. Exit codes: 0 done, 1 failed while running,\n"
      "2 unusable command line, configuration or log, 130 interrupted.");
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::Throw);
  app.add_option("--log", options.log, "CARMEN log to play, plain or gzip")->option_text("FILE")->check(NoOption);
  app.add_option("--rate", options.rate, "Play at N times real time; 0, the default: as fast as possible")
      ->option_text("N")
      ->check(RateOrNothing);
  app.add_option("--scans", options.scans, "Stop after N scans")->option_text("N")->check(WholeNumberFromOne);
  app.add_option("--out", options.out, "Folder for the files (default: slam2d_out)")
      ->option_text("DIR")
      ->check(NoOption);
  app.add_option("--config", options.configs, "YAML: which nodes run here, and how to reach the others; repeatable")
      ->option_text("FILE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(NoOption);
  app.add_option("--params", options.params.files, "YAML: parameters of the nodes, below slam; repeatable")
      ->option_text("FILE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(NoOption);
  app.add_option("--param", taken_before, "One parameter, as in slam.matcher.max_range_m=20; repeatable")
      ->option_text("PATH=VALUE");
  app.add_option("--move-mapper-at", options.move_mapper_at, "At scan K, move the mapper to a process on standby")
      ->option_text("K")
      ->check(WholeNumberFromOne);
  app.add_option("--relations", options.relations, "Compare with these relations: errors of relative poses")
      ->option_text("FILE")
      ->check(NoOption);
  app.add_option("--patience", patience_s, "Seconds to wait for other processes (default: 30)")
      ->option_text("S")
      ->check(WholeNumberFromOne);
  app.add_flag("--list-params", options.list_params, "List the parameters of a demo that runs in another process");
  app.add_option("--set-param", set_params, "Set a parameter of a demo that runs in another process; repeatable")
      ->option_text("PATH=VALUE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(Assignment);
  app.add_flag("--save-map", options.save_map, "Make a demo that runs in another process write its map now");
  app.add_flag("--quiet", options.quiet, "Print warnings and errors only, no progress");
  app.add_flag("--json", options.json, "Print the result as JSON, one object per line");
  try {
    std::vector<std::string> arguments(argv + 1, argv + argc);
    options.params.overrides = hgros::ParamOverridesOfEnvironment();
    std::ranges::move(hgros::TakeParamArguments(arguments), std::back_inserter(options.params.overrides));
    std::ranges::reverse(arguments);  // CLI11 expects them reversed.
    app.parse(std::move(arguments));
  } catch (const hgros::ParamError& error) {
    std::fprintf(stderr, "slam2d: %s\n", error.what());
    return static_cast<int>(kBadInput);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "slam2d: %s --help lists the options.\n", Sentence(app, error).c_str());
    return static_cast<int>(kBadInput);
  }
  options.patience = std::chrono::seconds(patience_s);
  if (options.rate) {
    options.params.overrides.push_back(
        {kTunedSource.prefix + std::string(".rate"), hgros::ParamCodec<double>::Write(*options.rate).text, "--rate"});
  }
  for (const std::string& text : set_params) {
    const std::size_t equals = text.find('=');
    options.set_params.push_back({text.substr(0, equals), text.substr(equals + 1), "--set-param"});
  }
  return options;
}

void CheckAgainst(const Plan& plan, const Options& options) {
  const auto require = [&plan](bool given, const char* option, const char* node) {
    if (!given || plan.Runs(node)) return;
    throw std::runtime_error(std::string(option) + " is for the process that runs the " + node +
                             "; this one runs only " + Enumerate({plan.nodes.begin(), plan.nodes.end()}) + ".");
  };
  require(options.log.has_value(), "--log", "source");
  require(options.rate.has_value(), "--rate", "source");
  require(options.scans.has_value(), "--scans", "source");
  require(options.move_mapper_at.has_value(), "--move-mapper-at", "source");
  require(options.move_mapper_at.has_value(), "--move-mapper-at", "matcher");
  require(options.move_mapper_at.has_value(), "--move-mapper-at", "mapper");
  require(options.relations.has_value(), "--relations", "writer");
}

}  // namespace slam2d

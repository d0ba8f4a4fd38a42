#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "commands/commands.hpp"
#include "hgros/base/names.hpp"
#include "hgros/component/component_catalog.hpp"
#include "robot/param_text.hpp"
#include "terminal/progress.hpp"
#include "terminal/records.hpp"
#include "terminal/sheet.hpp"
#include "terminal/units.hpp"
#include "terminal/visible_text.hpp"
#include "trial/component_trial.hpp"

namespace hgros::cli {
namespace {

class ComponentsCommand final : public Command {
 public:
  void Declare(Arguments& arguments) override {
    arguments.Positional(
        {"TYPE", "", "Only these, with everything about them, such as words/Counter", ValueKind::kName, {}, false},
        wanted_);
    arguments.Option("--library", "FILE", libraries_, "The components of this shared library, installed or not",
                     ValueKind::kFile);
    arguments.Option("--has", "TYPE", has_, "Print nothing; fail unless these can be constructed");
    arguments.Flag("--json", style_.json, "One JSON object per line");
    arguments.Flag("--exact", style_.exact, "Numbers with all digits, without units");
  }
  [[nodiscard]] std::string Description() const override {
    return "Shows the component types of the installed libraries: their channels, services and parameters. Each is "
           "constructed once, in a process of its own, where nothing of it runs. Libraries are found by their "
           "manifests, in the folders of HGROS_COMPONENT_PATH and in share/hgros/components. A component in Python is "
           "named by its module and class.";
  }
  [[nodiscard]] std::vector<Example> Examples() const override {
    return {{"hgros components", "Lists all components."},
            {"hgros components words/Counter", "Shows channels, types and parameters of one."},
            {"hgros components my_module:Tracker", "Shows a class of Python in the current folder or PYTHONPATH."},
            {"hgros components --library ./libwords.so", "Lists those of a library that is not installed."}};
  }
  int Run(Surroundings& surroundings) override;

 private:
  [[nodiscard]] std::vector<TriedLibrary> Try(Surroundings& surroundings) const;
  int Check(const std::vector<TriedLibrary>& tried) const;
  void List(Console& console, const std::vector<TriedLibrary>& tried) const;
  void Show(Console& console, const TriedLibrary& library, const TriedComponent& component) const;

  std::vector<std::string> wanted_;
  std::vector<std::string> libraries_;
  std::vector<std::string> has_;
  OutputStyle style_;
};

std::vector<std::string> ChannelsOf(const std::vector<ComponentChannel>& channels) {
  std::vector<std::string> names;
  for (const ComponentChannel& one : channels) {
    if (std::ranges::find(names, one.name) == names.end()) names.push_back(one.name);
  }
  return names;
}

std::vector<TriedLibrary> ComponentsCommand::Try(Surroundings& surroundings) const {
  const Progress progress(surroundings.console, surroundings.pause, "constructing components");
  std::vector<TriedLibrary> tried;
  if (!libraries_.empty()) {
    for (const std::string& one : libraries_) tried.push_back(TryLibrary(one, wanted_, surroundings.pause));
    return tried;
  }
  const ComponentCatalog catalog;
  for (const std::string& fault : catalog.faults()) surroundings.console.Say(Visible(fault));
  if (!wanted_.empty()) {
    for (const std::string& one : wanted_) {
      const ComponentLibrary& library = catalog.Find(one);
      if (library.language.empty()) {
        tried.push_back(TryLibrary(library.file, {one}, surroundings.pause));
      } else {  // It finds its types by their names.
        tried.push_back({library.file, TryComponents({{.name = one, .type = one}}, catalog, surroundings.pause), {}});
      }
    }
    return tried;
  }
  for (const ComponentLibrary& one : catalog.libraries()) {
    if (!one.language.empty()) continue;  // Its types are known only to the programs that name them.
    tried.push_back(TryLibrary(one.file, one.types, surroundings.pause));
  }
  return tried;
}

int ComponentsCommand::Check(const std::vector<TriedLibrary>& tried) const {
  std::vector<std::string> names;
  for (const TriedLibrary& library : tried) {
    for (const TriedComponent& one : library.components) names.push_back(one.name);
  }
  for (const std::string& wanted : has_) {
    if (std::ranges::find(names, wanted) != names.end()) continue;
    const std::string nearest = NearestName(wanted, names);
    throw Error("The library has no component \"" + wanted + "\".", {},
                nearest.empty() ? "Add HGROS_COMPONENT(Class, \"" + wanted + "\") to one of its sources."
                                : "Did you mean \"" + nearest + "\"?");
  }
  for (const TriedLibrary& library : tried) {
    for (const TriedComponent& one : library.components) {
      if (std::ranges::find(has_, one.name) == has_.end() || one.description) continue;
      throw Error(one.faults.front());
    }
  }
  return kDone;
}

void ComponentsCommand::List(Console& console, const std::vector<TriedLibrary>& tried) const {
  Records records(console, style_,
                  {{"type", "TYPE"},
                   {"subscribes", "SUBSCRIBES"},
                   {"publishes", "PUBLISHES"},
                   {"serves", "SERVES"},
                   {"params", "PARAMS", true},
                   {"fault", ""},
                   {"library", "LIBRARY"}});
  for (const TriedLibrary& library : tried) {
    const std::string file = library.file.string();
    const std::string shown = Visible(library.file.filename().string());
    for (const TriedComponent& one : library.components) {
      if (!one.description) {
        records.Add({one.name, {}, {}, {}, {}, one.faults.front().what(), Cell(file, shown)});
        continue;
      }
      std::vector<std::string> services;
      for (const ComponentService& service : one.description->services) services.push_back(service.name);
      records.Add({one.name,
                   ChannelsOf(one.description->inputs),
                   ChannelsOf(one.description->outputs),
                   services,
                   std::uint64_t{one.description->params.size()},
                   {},
                   Cell(file, shown)});
    }
  }
  records.End();
}

Sheet::Table ChannelTable(const std::string& key, const std::string& heading,
                          const std::vector<ComponentChannel>& channels) {
  Sheet::Table table{key, {{"channel", heading}, {"type", "TYPE"}}, {}};
  for (const ComponentChannel& one : channels)
    table.rows.push_back({one.name, one.type.empty() ? Cell("any") : one.type});
  return table;
}

Sheet::Table ServiceTable(const std::string& key, const std::string& heading,
                          const std::vector<ComponentService>& services) {
  Sheet::Table table{key, {{"service", heading}, {"request", "REQUEST"}, {"reply", "REPLY"}}, {}};
  for (const ComponentService& one : services) table.rows.push_back({one.name, one.request, one.reply});
  return table;
}

void ComponentsCommand::Show(Console& console, const TriedLibrary& library, const TriedComponent& component) const {
  const ComponentDescription& it = *component.description;
  Sheet sheet("component", component.name);
  sheet.Fact("library", "Library", library.file.string());
  sheet.Fact("state", "Saves and restores", it.state);
  sheet.Fact("transforms", it.transforms ? "Transforms" : "", Cell(it.transforms, "sets or looks them up"));
  sheet.Add(ChannelTable("subscribes", "SUBSCRIBES", it.inputs));
  sheet.Add(ChannelTable("publishes", "PUBLISHES", it.outputs));
  sheet.Add(ServiceTable("serves", "SERVES", it.services));
  sheet.Add(ServiceTable("calls", "CALLS", it.calls));
  Sheet::Table timers{"timers", {{"timer", "TIMER"}, {"period_ns", "PERIOD", true}}, {}};
  for (const ComponentTimer& one : it.timers) {
    timers.rows.push_back(
        {one.name, Cell(std::int64_t{one.period.count()}, DurationText(one.period.count(), style_.exact))});
  }
  sheet.Add(std::move(timers));
  Sheet::Table params{"params",
                      {{"path", "PARAMETER"},
                       {"default", "DEFAULT"},
                       {"unit", "UNIT"},
                       {"type", "TYPE"},
                       {"least", ""},
                       {"most", ""},
                       {"choices", ""},
                       {"", "RANGE"},
                       {"description", "DESCRIPTION"}},
                      {}};
  const auto bound = [](const std::optional<double>& value) { return value ? Cell(*value, {}) : Cell(); };
  for (const ParamDeclaration& one : it.params) {
    params.rows.push_back({one.path, one.fallback, one.info.unit, one.type, bound(one.info.least), bound(one.info.most),
                           one.info.choices, Cell(std::string(), RangeText(one.info)), one.info.description});
  }
  sheet.Add(std::move(params));
  sheet.Write(console, style_);
}

int ComponentsCommand::Run(Surroundings& surroundings) {
  Console& console = surroundings.console;
  const std::vector<TriedLibrary> tried = Try(surroundings);
  bool faults = false;
  const auto say = [&](const std::string& what) {
    console.Say(Visible(what));
    faults = true;
  };
  for (const TriedLibrary& library : tried) {
    if (!library.fault.empty())
      say(library.fault.find(library.file.string()) == std::string::npos ? library.file.string() + ": " + library.fault
                                                                         : library.fault);
    if (!has_.empty()) continue;
    for (const TriedComponent& one : library.components) {
      if (!one.description) say(library.file.string() + ": " + one.faults.front().what());
    }
  }
  if (!has_.empty()) return faults ? kFailed : Check(tried);
  if (wanted_.empty()) {
    List(console, tried);
    if (tried.empty()) {
      console.Say("No component is installed. Name a library with --library, or its folder in HGROS_COMPONENT_PATH.");
    }
    return faults ? kFailed : kDone;
  }
  for (const TriedLibrary& library : tried) {
    for (const TriedComponent& one : library.components) {
      if (one.description) Show(console, library, one);
    }
  }
  return faults ? kFailed : kDone;
}

}  // namespace

std::unique_ptr<Command> MakeComponents() { return std::make_unique<ComponentsCommand>(); }

}  // namespace hgros::cli

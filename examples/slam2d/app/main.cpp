#include <chrono>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include <hgros/hgros.hpp>
#include <hgros/tf/transforms.hpp>

#include "../carmen_log.hpp"
#include "../nodes/mapper_move.hpp"
#include "../nodes/mapper_node.hpp"
#include "../nodes/matcher_node.hpp"
#include "../nodes/source_node.hpp"
#include "../nodes/writer_node.hpp"
#include "../relations_error.hpp"
#include "../simulated_building.hpp"
#include "await.hpp"
#include "channels.hpp"
#include "console.hpp"
#include "ending.hpp"
#include "options.hpp"
#include "parameters.hpp"
#include "plan.hpp"
#include "remote_commands.hpp"
#include "report.hpp"
#include "roll_call.hpp"
#include "signal_watch.hpp"

namespace slam2d {
namespace {

// The nodes of this process. They end once the ending is decided, which happens at the latest in the destructor.
struct Crew {
  explicit Crew(Ending& its_ending) : ending(its_ending) {}
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  ~Crew() { ending.Fail("The nodes were stopped."); }

  Ending& ending;
  std::optional<WriterNode> writer;
  std::optional<MapperNode> mapper;
  std::optional<MatcherNode> matcher;
  std::optional<SourceNode> source;
};

// Keeps the last message on `done`.
class DoneWatch {
 public:
  DoneWatch(hgros::Session& session, Ending& ending)
      : subscription_(
            session.FromAny<msg::Done>(kDone, hgros::Invoke::kSerial,
                                       [this, &ending](const msg::Done& done) {
                                         {
                                           const std::scoped_lock lock(mutex_);
                                           done_ = done;
                                         }
                                         if (done.error().empty()) {
                                           ending.Succeed();
                                         } else {
                                           ending.Fail(done.error());
                                         }
                                       },
                                       {.name = "ending", .queue = hgros::Queue::KeepAll(1), .executor = {}})) {}

  [[nodiscard]] std::optional<msg::Done> done() const {
    const std::scoped_lock lock(mutex_);
    return done_;
  }

 private:
  mutable std::mutex mutex_;
  std::optional<msg::Done> done_;
  hgros::Subscription subscription_;
};

ScanReader OpenSource(const Options& options) {
  if (options.log) {
    auto reader = std::make_shared<CarmenLogReader>(*options.log);
    return [reader](LaserScan2& scan) {
      std::optional<LaserScan2> next = reader->Next();
      if (next) scan = std::move(*next);
      return next.has_value();
    };
  }
  SimulationOptions simulation;
  simulation.scans = options.scans.value_or(Options::kSimulatedScans);
  auto building = std::make_shared<SimulatedBuilding>(simulation);
  return [building](LaserScan2& scan) { return building->Next(scan); };
}

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::runtime_error("The folder " + folder.string() + " cannot be created: " + error.message() + ".");
}

// Waits for the other processes, answers the roll call, and starts the source when all have answered.
void Begin(const Plan& plan, const Options& options, hgros::Session& session, RollCall& roll_call, Crew& crew,
           Console& console) {
  struct Input {
    std::string_view channel;
    const char* from;  // The node that publishes it.
    bool needed;
  };
  const Input inputs[] = {{kScan, "source", plan.Runs("matcher")},
                          {kPreChannel, "matcher", plan.Runs("mapper") && !plan.standby},
                          {kNextChannel, "mapper", plan.Runs("matcher") || plan.Runs("writer")},
                          {kDone, "writer", true},
                          {kMapState, "mapper", plan.standby}};
  const auto deadline = std::chrono::steady_clock::now() + options.patience;
  for (const Input& input : inputs) {
    const bool here = plan.Runs(input.from) && !(plan.standby && input.channel == kMapState);
    if (!input.needed || here) continue;
    if (!session.WaitForPublishers(input.channel, 1, std::chrono::milliseconds(300))) {
      console.Say("Waiting for the " + std::string(input.from) + " of another process, up to " +
                  std::to_string(options.patience.count()) + " s.");
    }
    if (!AwaitUnlessStopped(crew.ending.token(), deadline,
                            [&](auto timeout) { return session.WaitForPublishers(input.channel, 1, timeout); })) {
      crew.ending.Fail("There is no publisher of \"" + std::string(input.channel) + "\": no other process with the " +
                       input.from + " was found within " + std::to_string(options.patience.count()) +
                       " s. Start it, and compare the endpoints and channels of the configuration files.");
      return;
    }
  }
  if (plan.standby) return;  // It answers once it has taken over.
  roll_call.Answer(plan.nodes);
  if (!crew.source) return;

  const std::vector<std::string> needed{"matcher", "mapper", "writer"};
  auto missing = roll_call.WaitFor(needed, std::chrono::steady_clock::now() + std::chrono::milliseconds(300));
  if (!missing.empty()) {
    console.Say("The source waits for " + Enumerate(missing) + ".");
    missing = roll_call.WaitFor(needed, deadline);
  }
  if (!missing.empty()) {
    crew.ending.Fail("No process with " + Enumerate(missing) + " was ready within " +
                     std::to_string(options.patience.count()) + " s.");
    return;
  }
  crew.source->Start();
}

std::uint64_t ScansSoFar(const Crew& crew) {
  if (crew.writer) return crew.writer->scans();
  if (crew.mapper) return crew.mapper->next_scan();
  if (crew.matcher) return crew.matcher->matched();
  return crew.source->sent();
}

void ShowProgress(const Plan& plan, const Options& options, const hgros::Session& session, bool log_time,
                  const Crew& crew, Console& console) {
  std::optional<std::uint64_t> all = options.scans;
  if (plan.Runs("source") && !options.log && !all) all = Options::kSimulatedScans;
  std::optional<std::chrono::steady_clock::time_point> began;
  std::uint64_t first = 0;
  while (!crew.ending.WaitUntil(std::chrono::steady_clock::now() + console.period())) {
    const std::uint64_t scans = ScansSoFar(crew);
    if (scans == 0) continue;
    const auto now = std::chrono::steady_clock::now();
    if (!began) {
      began = now;
      first = scans;
      continue;
    }
    const double per_second = static_cast<double>(scans - first) / std::chrono::duration<double>(now - *began).count();
    std::string text = "scan " + std::to_string(scans);
    if (all) text += " of " + std::to_string(*all);
    char more[64];
    std::snprintf(more, sizeof more, ", %.0f scans/s", per_second);
    text += more;
    if (log_time) {
      std::snprintf(more, sizeof more, ", log time %.1f s",
                    static_cast<double>(session.clock()->Now().nanoseconds) * 1e-9);
      text += more;
    }
    console.Progress(text);
  }
  console.EndProgress();
}

int Run(const Options& options) {
  Plan plan = ReadPlan(options.configs);
  const std::vector<std::string> own_sections{kPlanSection};
  hgros::Config config = hgros::Config::Load(options.configs, own_sections);
  if (options.configs.empty()) config.simulated_time = true;  // Configuration files contain this setting.
  if (options.asks()) return AskRunningDemo(options, config);
  const std::vector<std::string> left_to_others = LeaveToOthers(plan, config.closed_channels);
  CheckAgainst(plan, options);
  const auto relations = options.relations ? ReadRelations(*options.relations) : std::vector<Relation>();
  ScanReader reader;
  if (plan.Runs("source")) reader = OpenSource(options);
  if (plan.Runs("writer")) MakeFolder(options.out);

  Console console(options.quiet);
  for (const std::string& sentence : left_to_others) console.Say(sentence);
  Ending ending;
  const SignalWatch signals([&ending](int signal) { ending.Interrupt(signal); });
  Parameters parameters(plan, options.params, console);
  hgros::Session session(config, {.name = "slam2d", .log = console.log()});
  hgros::Transforms transforms(session);
  RollCall roll_call(session, ending);
  const DoneWatch done(session, ending);
  Report report;
  {
    Crew crew(ending);
    if (plan.Runs("writer")) crew.writer.emplace(session, transforms, options.out, ending);
    if (plan.Runs("mapper")) {
      std::function<void(std::uint64_t)> taken_over;
      if (plan.standby) {
        console.Say("On standby.");
        taken_over = [&](std::uint64_t next_scan) {
          console.Say("The mapper now runs here and continues with scan " + std::to_string(next_scan) + ".");
          roll_call.Answer(plan.nodes, next_scan);
        };
      }
      crew.mapper.emplace(session, *parameters.mapper, ending, console, std::move(taken_over));
    }
    if (plan.Runs("matcher")) crew.matcher.emplace(session, transforms, *parameters.matcher, ending, console);
    if (plan.Runs("source")) {
      crew.source.emplace(session, transforms, std::move(reader), SourceOptions{options.scans, options.move_mapper_at},
                          *parameters.source, ending, console);
    }

    std::jthread move;
    std::jthread begin(
        [&] { ending.Guard("start", [&] { Begin(plan, options, session, roll_call, crew, console); }); });
    if (options.move_mapper_at) {
      move = std::jthread([&] {
        ending.Guard("move", [&] {
          MoveMapper(*options.move_mapper_at, options.patience, session, *crew.source, *crew.mapper, roll_call, ending,
                     console);
        });
      });
    }
    ShowProgress(plan, options, session, config.simulated_time, crew, console);

    report.graph = session.Snapshot().graph;
    if (crew.source) report.scans_sent = crew.source->sent();
    if (crew.writer) {
      // If the user interrupts a long log, the current map is written.
      const bool interrupted = ending.exit_code() > 128 && crew.writer->scans() > 0;
      report.written = interrupted ? crew.writer->WriteFiles() : crew.writer->written();
    }
    if (report.written && options.relations) {
      report.relations_error = CompareWithRelations(crew.writer->trajectory(), relations);
    }
  }
  report.done = done.done();
  if (!ending.sentence().empty()) console.Warn(ending.sentence());
  if (report.done || report.written) options.json ? PrintJson(report) : PrintText(report);
  return ending.exit_code();
}

}  // namespace
}  // namespace slam2d

int main(int argc, char** argv) {
  const auto options = slam2d::ReadCommandLine(argc, argv);
  if (const int* exit_code = std::get_if<int>(&options)) return *exit_code;
  try {
    return slam2d::Run(std::get<slam2d::Options>(options));
  } catch (const std::exception& error) {  // wiring: nothing has run yet
    std::fprintf(stderr, "slam2d: %s\n", error.what());
    return slam2d::kBadInput;
  }
}

#include "tracing/paths.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace hgros::cli {
namespace {

constexpr std::size_t kMostHops = 64;          // A peer may make circles.
constexpr std::size_t kMostSteps = 1'000'000;  // Of all ways together; some hundred MB.

using Run = Traced::Run;
using Publish = Traced::Publish;

// One message of a way, and who handled it.
struct Step {
  const Publish* publish = nullptr;
  const Run* run = nullptr;
};

class Walker {
 public:
  explicit Walker(const Traced& traced) {
    for (const Publish& one : traced.publishes) publishes_.emplace(one.message, &one);
    for (const Run& one : traced.runs) runs_.emplace(RunKey(one.message, one.session, one.node), &one);
  }

  enum class End { kFound, kBegan, kUnseen };
  // The way of the message that `last` has handled, back to `from`; in `steps` the last one first.
  End Back(const Run& last, std::string_view from, std::vector<Step>& steps) const {
    steps.clear();
    for (const Run* run = &last; steps.size() < kMostHops;) {
      const auto found = publishes_.find(run->message);
      if (found == publishes_.end()) return End::kUnseen;
      const Publish& publish = *found->second;
      steps.push_back({&publish, run});
      if (publish.channel == from) return End::kFound;
      if (publish.cause == 0) return End::kBegan;
      run = RunOf(publish);
      if (run == nullptr) return End::kUnseen;
    }
    return End::kUnseen;
  }

 private:
  // The callback that led to the publish. A publish outside of it names no node or another one, such as the node that
  // runs a service's handler; then any callback of the session.
  [[nodiscard]] const Run* RunOf(const Publish& publish) const {
    for (const std::string_view node : {std::string_view(publish.node), std::string_view()}) {
      const auto found = runs_.lower_bound(RunKey(publish.cause, publish.session, node));
      if (found == runs_.end()) continue;
      const Run& run = *found->second;
      const bool fits = run.message == publish.cause && run.session == publish.session;
      if (fits && (node.empty() || run.node == node)) return &run;
    }
    return nullptr;
  }

  using RunKey = std::tuple<std::uint64_t, std::size_t, std::string_view>;  // Message, session, node.
  // Ordered, and one entry for each key: peers choose the keys, and could make all of them equal or their hashes
  // collide.
  std::map<std::uint64_t, const Publish*> publishes_;
  std::map<RunKey, const Run*> runs_;
};

using Key = std::vector<std::tuple<std::string, std::size_t, std::size_t, std::string>>;

void AddStep(Hop& hop, const Step& step, const Publish* next) {
  const Run& run = *step.run;
  const std::int64_t begin = step.publish->at_ns;
  if (run.sent_ns) {
    hop.encode.Add(Difference(*run.sent_ns, begin));
    hop.transport.Add(Difference(run.received_ns, *run.sent_ns));
  } else {
    hop.encode.Add(0);
    hop.transport.Add(0);
  }
  hop.wait.Add(Difference(run.start_ns, run.sent_ns ? run.received_ns : begin));
  const std::int64_t end = next == nullptr ? run.start_ns : next->at_ns;
  hop.run.Add(Difference(next == nullptr ? run.end_ns : end, run.start_ns));
  hop.all.Add(Difference(end, begin));
}

void FindShares(Path& path) {
  const double whole = path.all.Mean();
  for (Hop& hop : path.hops) hop.share = whole > 0 ? hop.all.Mean() / whole : 0;
  const auto longest = std::ranges::max_element(path.hops, {}, &Hop::share);
  if (longest != path.hops.end()) longest->critical = true;
}

}  // namespace

std::int64_t Durations::Quantile(double q) const {
  if (all_.empty()) return 0;
  std::vector<std::int64_t> values = all_;
  const auto at = std::min(values.size() - 1, static_cast<std::size_t>(q * static_cast<double>(values.size())));
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(at));
  return values[at];
}

double Durations::Mean() const {
  const double sum = std::accumulate(all_.begin(), all_.end(), 0.0);
  return all_.empty() ? 0 : sum / static_cast<double>(all_.size());
}

Paths PathsBetween(const Traced& traced, std::string_view from, std::string_view to) {
  const Walker walker(traced);
  Paths found;
  std::map<Key, Path> paths;
  std::vector<Step> steps;
  std::size_t left = kMostSteps;
  for (const Run& last : traced.runs) {
    if (last.channel != to) continue;
    ++found.arrived;
    if (left < kMostHops) {
      ++found.lost;
      continue;
    }
    const Walker::End end = walker.Back(last, from, steps);
    left -= steps.size();
    if (end == Walker::End::kUnseen) ++found.interrupted;
    if (end == Walker::End::kBegan) ++found.origins[steps.back().publish->channel];
    if (end != Walker::End::kFound) continue;
    std::ranges::reverse(steps);
    Key key;
    for (const Step& step : steps) {
      key.emplace_back(step.publish->channel, step.publish->session, step.run->session, step.run->node);
    }
    Path& path = paths[key];
    ++path.messages;
    path.hops.resize(steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) {
      Hop& hop = path.hops[i];
      std::tie(hop.channel, hop.publisher, hop.session, hop.node) = key[i];
      AddStep(hop, steps[i], i + 1 < steps.size() ? steps[i + 1].publish : nullptr);
    }
    path.all.Add(Difference(last.start_ns, steps.front().publish->at_ns));
  }
  for (auto& [key, path] : paths) {
    FindShares(path);
    found.paths.push_back(std::move(path));
  }
  std::ranges::stable_sort(found.paths, std::ranges::greater(), &Path::messages);
  return found;
}

}  // namespace hgros::cli

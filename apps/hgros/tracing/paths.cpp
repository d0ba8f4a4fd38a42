#include "tracing/paths.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace hgros::cli {
namespace {

constexpr std::size_t kMostHops = 64;  // A peer may make circles.

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
    for (const Run& one : traced.runs) runs_.emplace(one.message, &one);
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
  // The callback that led to the publish. A publish outside of it names no node; then any callback of the session.
  [[nodiscard]] const Run* RunOf(const Publish& publish) const {
    const auto [begin, end] = runs_.equal_range(publish.cause);
    const Run* any = nullptr;
    for (auto one = begin; one != end; ++one) {
      if (one->second->session != publish.session) continue;
      if (one->second->node == publish.node) return one->second;
      any = one->second;
    }
    return publish.node.empty() ? any : nullptr;
  }

  std::unordered_map<std::uint64_t, const Publish*> publishes_;
  std::unordered_multimap<std::uint64_t, const Run*> runs_;
};

using Key = std::vector<std::tuple<std::string, std::size_t, std::size_t, std::string>>;

void AddStep(Hop& hop, const Step& step, const Publish* next) {
  const Run& run = *step.run;
  const std::int64_t begin = step.publish->at_ns;
  if (run.sent_ns) {
    hop.encode.Add(*run.sent_ns - begin);
    hop.transport.Add(run.received_ns - *run.sent_ns);
  } else {
    hop.encode.Add(0);
    hop.transport.Add(0);
  }
  hop.wait.Add(run.start_ns - (run.sent_ns ? run.received_ns : begin));
  const std::int64_t end = next == nullptr ? run.start_ns : next->at_ns;
  hop.run.Add((next == nullptr ? run.end_ns : end) - run.start_ns);
  hop.all.Add(end - begin);
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
  for (const Run& last : traced.runs) {
    if (last.channel != to) continue;
    ++found.arrived;
    const Walker::End end = walker.Back(last, from, steps);
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
    path.all.Add(last.start_ns - steps.front().publish->at_ns);
  }
  for (auto& [key, path] : paths) {
    FindShares(path);
    found.paths.push_back(std::move(path));
  }
  std::ranges::stable_sort(found.paths, std::ranges::greater(), &Path::messages);
  return found;
}

}  // namespace hgros::cli

#include <algorithm>
#include <string_view>
#include <utility>

#include "config/config_draft.hpp"
#include "hgros/base/names.hpp"
#include "hgros/config/setting_readers.hpp"
#include "hgros/yaml/quoted.hpp"

namespace hgros {
namespace {

using yaml::Field;
using yaml::Section;
using yaml::Settle;
using yaml::Value;

constexpr std::int64_t kMostMessages = 1'000'000;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 40U;
constexpr std::int64_t kMostThreads = 1024;
constexpr std::int64_t kHighestPriority = 99;
constexpr std::size_t kLosslessMessages = 1000;
constexpr std::size_t kLosslessBytes = std::size_t{256} * 1024 * 1024;

std::size_t ReadMessageCount(const Value& value, std::int64_t least) {
  return static_cast<std::size_t>(value.Integer(least, kMostMessages));
}

Queue ReadKeepAll(const Value& value) {
  if (value.kind() != yaml::Node::Kind::kMap) return Queue::KeepAll(ReadMessageCount(value, 1));
  const Section section(value, "a number of messages or a map", {"messages", "bytes"});
  const std::size_t messages = ReadMessageCount(section.Require("messages"), 1);
  const auto bytes = section.Find("bytes");
  return bytes ? Queue::KeepAll(messages, bytes->SizeBytes(1, kMostBytes)) : Queue::KeepAll(messages);
}

Queue ReadQueue(const Value& value) {
  constexpr std::string_view kForms =
      "Write latest, {keep_last: 16}, {keep_all: 1000} or {keep_all: {messages: 1000, bytes: 64MiB}}.";
  if (value.kind() != yaml::Node::Kind::kMap) {
    const std::string& text = value.Text("a queue");
    if (text == "latest") return Queue::Latest();
    const std::vector<std::string> known = {"latest"};
    const std::string nearest = text.size() <= 64 ? NearestName(text, known) : std::string();
    value.FailType("a queue", (nearest.empty() ? "" : "Did you mean \"" + nearest + "\"? ") + std::string(kForms));
  }
  const Section section(value, "a queue", {"keep_last", "keep_all"});
  const auto keep_last = section.Find("keep_last");
  const auto keep_all = section.Find("keep_all");
  if (keep_last.has_value() == keep_all.has_value()) value.Fail("must have either keep_last or keep_all", kForms);
  return keep_last ? Queue::KeepLast(ReadMessageCount(*keep_last, 1)) : ReadKeepAll(*keep_all);
}

Executor ReadExecutor(const Value& value) {
  constexpr auto kOf = [](std::size_t kind) {
    return kind == 0 ? Executor::Tbb() : kind == 1 ? Executor::Inline() : Executor::Dedicated();
  };
  const auto choose = [](const Value& kind) { return kind.Choice({"tbb", "inline", "dedicated"}); };
  if (value.kind() == yaml::Node::Kind::kText) return kOf(choose(value));
  const Section section(value, "tbb, inline, dedicated or a map with kind", {"kind", "cpus", "priority"});
  const std::size_t kind = choose(section.Require("kind"));
  const auto cpus = section.Find("cpus");
  const auto priority = section.Find("priority");
  if (kind == 2) {
    return Executor::Dedicated(cpus ? ReadCpus(*cpus) : std::vector<int>(),
                               priority ? static_cast<int>(priority->Integer(0, kHighestPriority)) : 0);
  }
  if (cpus) cpus->Fail("applies only to a dedicated executor", "Write kind: dedicated, or remove it.");
  if (priority) priority->Fail("applies only to a dedicated executor", "Write kind: dedicated, or remove it.");
  return kOf(kind);
}

std::vector<std::string> ReadTransports(const Value& value) {
  std::vector<std::string> transports;
  const auto add = [&transports](const Value& one) {
    const std::string_view key = std::data(kTransportKeys)[one.Choice(kTransportKeys)];
    if (std::ranges::find(transports, key) != transports.end()) {
      one.Fail("is " + yaml::Quoted(key) + ", which the list already has", "Keep one of them.");
    }
    transports.emplace_back(key);
  };
  if (value.kind() != yaml::Node::Kind::kList) {
    add(value);
    return transports;
  }
  for (const Value& one : value.List({})) add(one);
  if (transports.empty()) {
    std::string known;
    for (const std::string_view key : kTransportKeys) known.append(known.empty() ? "" : ", ").append(key);
    value.Fail("lists no transport",
               "Name at least one of " + known + ". To keep messages in their process, publish them with ToGraph.");
  }
  std::ranges::sort(transports);
  return transports;
}

void RefuseOldKeys(const Value& channel) {
  if (channel.kind() != yaml::Node::Kind::kMap) return;
  for (const Field& field : channel.Map({})) {
    if (field.key != "carriers") continue;
    throw ConfigError("`carriers` is called `transports` now.", field.key_position, "Write transports.");
  }
}

void ReadNodes(const Value& map, ConfigDraft& draft) {
  const auto read = [&draft](const Field& field) {
    if (field.key.empty()) throw ConfigError("The name of the node is empty.", field.key_position, "Write its name.");
    const Section section(field.value, "a map with executor and queue", {"executor", "queue"});
    ConfigDraft::Node& node = draft.nodes[field.key];
    section.Read("executor", [&](const Value& executor) { Settle(node.executor, ReadExecutor(executor), executor); });
    section.Read("queue", [&](const Value& queue) { Settle(node.queue, ReadQueue(queue), queue); });
  };
  const std::vector<Field> fields = map.Map("a map from node names to their settings");
  for (const Field& field : fields) field.value.faults().Attempt([&] { read(field); });
}

void ReadChannel(const Field& field, ConfigDraft& draft) {
  CheckChannelName(field.key, field.key_position);
  RefuseOldKeys(field.value);
  const Section section(field.value, "a map with queue, lossless, latched and transports",
                        {"queue", "lossless", "latched", "transports"});
  ConfigDraft::Channel& channel = draft.channels[field.key];
  std::optional<Queue> wanted;
  section.Read("queue", [&](const Value& queue) { wanted = ReadQueue(queue); });
  section.Read("lossless", [&](const Value& lossless) {
    const bool all = lossless.Boolean();
    if (wanted && wanted->lossless() != all) {
      lossless.Fail("contradicts the queue at " + section.Require("queue").position().ToString(),
                    "Remove it; keep_all is lossless.");
    }
    if (!wanted && all) wanted = Queue::KeepAll(kLosslessMessages, kLosslessBytes);
  });
  const auto queue = section.Find("queue");
  if (wanted) Settle(channel.queue, *wanted, queue ? *queue : section.Require("lossless"));
  section.Read("latched",
               [&](const Value& latched) { Settle(channel.latched, ReadMessageCount(latched, 0), latched); });
  section.Read("transports",
               [&](const Value& transports) { Settle(channel.transports, ReadTransports(transports), transports); });
}

}  // namespace

std::vector<int> ReadCpus(const Value& list) {
  constexpr std::int64_t kLastCpu = 1023;  // Of a cpu_set_t.
  std::map<int, FilePosition> cpus;
  const auto read = [&](const Value& item) {
    const int cpu = static_cast<int>(item.Integer(0, kLastCpu));
    const auto [first, fresh] = cpus.emplace(cpu, item.position());
    if (!fresh) item.Fail("is a CPU that the list already has at " + first->second.ToString(), "Keep one of them.");
  };
  const std::vector<Value> items = list.List("a list of CPU numbers");
  for (const Value& item : items) item.faults().Attempt([&] { read(item); });
  std::vector<int> out;
  for (const auto& [cpu, position] : cpus) out.push_back(cpu);
  return out;
}

NodeOverrides ReadNodeOverrides(const Value& map) {
  ConfigDraft draft;
  ReadNodes(map, draft);
  NodeOverrides nodes;
  for (const auto& [name, node] : draft.nodes) {
    nodes[name] = {node.queue ? std::optional(node.queue->value) : std::nullopt,
                   node.executor ? std::optional(node.executor->value) : std::nullopt};
  }
  return nodes;
}

void ReadDataGraph(const Value& value, ConfigDraft& draft) {
  const Section section(value, "a map", {"close_channels", "threads", "nodes"});
  section.Read("close_channels", [&](const Value& closed) {
    if (closed.kind() != yaml::Node::Kind::kNull) draft.closed_channels.merge(ReadChannelNames(closed));
  });
  section.Read("threads", [&](const Value& threads) {
    Settle(draft.threads, static_cast<int>(threads.Integer(0, kMostThreads)), threads);
  });
  section.Read("nodes", [&](const Value& nodes) { ReadNodes(nodes, draft); });
}

void ReadChannels(const Value& value, ConfigDraft& draft) {
  const std::vector<Field> fields = value.Map("a map from channel names to their settings");
  for (const Field& field : fields) field.value.faults().Attempt([&] { ReadChannel(field, draft); });
}

}  // namespace hgros

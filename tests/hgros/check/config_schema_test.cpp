// The JSON Schema says what the strict reader says.
#include "check/config_schema.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidjson/document.h>
#include <rapidjson/internal/regex.h>
#include <rapidjson/schema.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/check/documented_files.hpp"
#include "hgros/config/config.hpp"
#include "hgros/placement/robot_file.hpp"
#include "hgros/yaml/document.hpp"
#include "support/error_of.hpp"
#include "support/scratch_folder.hpp"

namespace hgros::cli {
namespace {

using rapidjson::Value;

// As YAML's core schema resolves it.
Value JsonOf(const yaml::Node& node, rapidjson::Document::AllocatorType& allocator) {
  Value json;
  switch (node.kind) {
    case yaml::Node::Kind::kNull: break;
    case yaml::Node::Kind::kList:
      json.SetArray();
      for (const yaml::Node* item : node.items) json.PushBack(JsonOf(*item, allocator), allocator);
      break;
    case yaml::Node::Kind::kMap:
      json.SetObject();
      for (const yaml::Node::Entry& entry : node.entries) {
        json.AddMember(Value(entry.key->text.c_str(), allocator), JsonOf(*entry.value, allocator), allocator);
      }
      break;
    case yaml::Node::Kind::kText:
      if (!node.quoted && (node.text == "true" || node.text == "false")) {
        json.SetBool(node.text == "true");
      } else if (!node.quoted && std::regex_match(node.text, std::regex("[-+]?[0-9]{1,18}"))) {
        json.SetInt64(std::stoll(node.text));
      } else if (!node.quoted && std::regex_match(node.text, std::regex("[-+]?([0-9]*\\.[0-9]+|[0-9]+\\.)"))) {
        json.SetDouble(std::stod(node.text));
      } else {
        json.SetString(node.text.c_str(), allocator);
      }
      break;
  }
  return json;
}

const Value& Resolved(const Value& schema, const Value& root) {
  if (!schema.IsObject() || !schema.HasMember("$ref")) return schema;
  const std::string name = std::string(schema["$ref"].GetString()).substr(std::string("#/definitions/").size());
  return Resolved(root["definitions"][name.c_str()], root);
}

// With copies in place of references, because RapidJSON 1.1 crashes at some of them.
Value Expanded(const Value& schema, const Value& root, rapidjson::Document::AllocatorType& allocator) {
  const Value& one = Resolved(schema, root);
  Value copy(one.GetType());
  if (one.IsObject()) {
    for (const auto& member : one.GetObject()) {
      copy.AddMember(Value(member.name, allocator), Expanded(member.value, root, allocator), allocator);
    }
  } else if (one.IsArray()) {
    for (const Value& item : one.GetArray()) copy.PushBack(Expanded(item, root, allocator), allocator);
  } else {
    copy.CopyFrom(one, allocator);
  }
  return copy;
}

class ConfigSchema : public testing::Test {
 protected:
  ConfigSchema() { schema_.Parse(std::string(ConfigSchemaText()).c_str()); }

  // Why the schema refuses the text; empty: it accepts it.
  [[nodiscard]] static std::string Refuses(const std::string& yaml, const std::vector<std::string>& sections = {}) {
    return RefusesBy(ConfigSchemaWith(sections), yaml);
  }
  [[nodiscard]] static std::string RefusesBy(const std::string& schema_text, const std::string& yaml) {
    rapidjson::Document schema;
    schema.Parse(schema_text.c_str());
    rapidjson::Document expanded;
    expanded.CopyFrom(Expanded(schema, schema, expanded.GetAllocator()), expanded.GetAllocator());
    expanded.RemoveMember("definitions");
    const rapidjson::SchemaDocument rules(expanded);
    rapidjson::SchemaValidator validator(rules);
    rapidjson::Document json;
    JsonOf(yaml::Document::Parse(yaml, "robot.yaml").root(), json.GetAllocator()).Accept(validator);
    return validator.IsValid() ? std::string() : validator.GetInvalidSchemaKeyword();
  }

  rapidjson::Document schema_;
};

// The first fault that the strict reader tells; empty: none.
std::string FaultInReader(const std::string& yaml) {
  return test::ErrorOf([&] { return Config::Parse(yaml); });
}

TEST_F(ConfigSchema, UsesOnlyKeywordsThatTheseTestsKnow) {
  ASSERT_FALSE(schema_.HasParseError());
  const std::set<std::string> known{
      "$schema",    "title",         "description",   "type",          "additionalProperties",
      "properties", "propertyNames", "anyOf",         "$ref",          "items",
      "required",   "pattern",       "not",           "minLength",     "default",
      "minimum",    "maximum",       "maxLength",     "minItems",      "uniqueItems",
      "enum",       "dependencies",  "minProperties", "maxProperties", "definitions"};
  const std::set<std::string> with_names{"properties", "dependencies", "definitions"};
  const std::function<void(const Value&)> visit = [&](const Value& schema) {
    if (schema.IsArray()) {
      for (const Value& one : schema.GetArray()) visit(one);
    }
    if (!schema.IsObject()) return;
    for (const auto& member : schema.GetObject()) {
      const std::string keyword = member.name.GetString();
      EXPECT_TRUE(known.contains(keyword)) << keyword;
      if (keyword == "pattern") {
        EXPECT_TRUE(rapidjson::internal::Regex(member.value.GetString()).IsValid()) << member.value.GetString();
      }
      if (with_names.contains(keyword)) {
        for (const auto& named : member.value.GetObject()) visit(named.value);
      } else if (keyword != "enum" && keyword != "default") {
        visit(member.value);
      }
    }
  };
  visit(schema_);
}

TEST_F(ConfigSchema, AcceptsEveryDocumentedExampleAsTheReaderDoes) {
  std::vector<DocumentedFile> files = DocumentedFiles();
  for (const char* name :
       {"everything", "paper_close_channels", "paper_data_graph", "paper_network_setting", "paper_visualization"}) {
    const auto path = RepositoryFolder() / "tests/config/yaml" / (std::string(name) + ".yaml");
    files.push_back({path.string(), {}, ContentsOf(path)});
  }
  for (const char* yaml :
       {"", "network:", "network: {publisher: [], subscribers: , security: }", "channels: {1: , true: {}}",
        "network: {publisher: {ip: x, channels: [1, yes, true, a/b]}}", "discovery: {domain: 3, local: [1]}",
        "network: {publisher: [{ip: 'TCP://LOCALHOST:05553'}, {ip: 'tcp://[::1]:0'}, {ip: 'ipc://@robot'}]}",
        "network: {subscribers: [{ip: 'robot2:1'}, {ip: 'tcp://[fe80::1%eth0]:5555'}, {ip: 'IPC:///run/a'}]}",
        "network: {peer_queue_bytes: '64 MiB'}", "shared_memory: {limit_bytes: 0, wait: spin, spin_us: 0}",
        "data_graph: {close_channels: , threads: 1024, nodes: {a: , b: {executor: {kind: tbb}}}}",
        "data_graph: {nodes: {a: {executor: {kind: dedicated, cpus: [], priority: 0}}}}",
        "channels: {a: {queue: {keep_all: {messages: 1, bytes: 1GiB}}, latched: 0, transports: zmq}}"}) {
    files.push_back({yaml, {}, yaml});
  }
  EXPECT_GE(files.size(), 30U);
  for (const DocumentedFile& file : files) {
    std::string yaml = file.yaml;
    EXPECT_EQ(Refuses(yaml), "") << file.where;
    // The reader opens key files.
    yaml = std::regex_replace(yaml, std::regex("secret_key_file: \\S+"),
                              "secret_key: 'D:)Q[IlAW!ahhC2ac:9*A}h:p?([4%wOTJ%JR%cs'");
    yaml = std::regex_replace(yaml, std::regex("public_key: \\S+"),
                              "public_key: 'Yne@$$w-vo<fVvi]a<NY6T1ed:M$$fCG*[IaLV{hID'");
    EXPECT_EQ(FaultInReader(yaml), "") << file.where;
  }
}

// The last test of this file compares all keys, choices and bounds.
TEST_F(ConfigSchema, RefusesWhatTheReaderRefuses) {
  const std::vector<std::string> broken{
      "[network]",
      "network",
      "params: {}",
      "network: 5",
      "network: []",
      "network: {publisher: }",
      "network: {publisher: x}",
      "network: {publisher: {channels: [a]}}",
      "network: {publisher: {ip: x, chanels: [a]}}",
      "network: {publisher: {ip: x, channels: a}}",
      "network: {publisher: {ip: x, channels: }}",
      "network: {publisher: {ip: x, channels: [a, a]}}",
      "network: {publisher: {ip: x, channels: [a, 'b c']}}",
      "network: {publisher: {ip: x, channels: [[a]]}}",
      "network: {publisher: {ip: 5553}}",
      "network: {publisher: {ip: 'tcp://*'}}",
      "network: {publisher: {ip: 'tcpp://*:5553'}}",
      "network: {publisher: [{ip: 'tcp://::1:5553'}]}",
      "network: {publisher: {ip: 'ipc://bus'}}",
      "network: {subscribers: {ip: x}}",
      "network: {subscribers: [x]}",
      "network: {subscribers: [{ip: 'tcp://*:5553'}]}",
      "network: {subscribers: [{ip: 'tcp://robot2:*'}]}",
      "network: {security: {public_key: short}}",
      "network: {security: {public_key: 'Yne@$w-vo<fVvi]a<NY6T1ed:M$fCG*[IaLV~hID'}}",
      "network: {security: {secret_key: 'D:)Q[IlAW!ahhC2ac:9*A}h:p?([4%wOTJ%JR%cs', secret_key_file: a}}",
      "network: {security: {allowed_clients: [short]}}",
      "network: {security: {servers: {'robot2:1': short}}}",
      "network: {peer_queue_bytes: 0}",
      "network: {peer_queue_bytes: 64Mb}",
      "network: {heartbeat_ms: '100'}",
      "network: {peer_timeout_ms: 1.5}",
      "discovery: {local: maybe}",
      "discovery: {local: []}",
      "discovery: {local: [a, a]}",
      "discovery: {lan: 'true'}",
      "discovery: {lan: {}}",
      "discovery: {lan: {interface: [eth0]}}",
      "discovery: {lan: {interfaces: [a-name-of-16-byt]}}",
      "discovery: {domain: a/b}",
      "discovery: {domain: }",
      "shared_memory: {wait: busy, spin_us: 20}",
      "time: simulation",
      "time:",
      "data_graph: {threads: many}",
      "data_graph: {close_channels: a}",
      "data_graph: {nodes: {a: {executor: inlined}}}",
      "data_graph: {nodes: {a: {executor: {cpus: [1]}}}}",
      "data_graph: {nodes: {a: {executor: {kind: inline, cpus: [1]}}}}",
      "data_graph: {nodes: {a: {executor: {kind: dedicated, cpus: [1, 1]}}}}",
      "channels: {a: {queue: latst}}",
      "channels: {a: {queue: {}}}",
      "channels: {a: {queue: {keep_last: 0}}}",
      "channels: {a: {queue: {keep_last: 1, keep_all: 1}}}",
      "channels: {a: {queue: {keep_all: {bytes: 1}}}}",
      "channels: {a: {lossless: yes}}",
      "channels: {a: {transports: []}}",
      "channels: {a: {transports: [zmq, tcp]}}"};
  EXPECT_GE(broken.size(), 50U);
  for (const std::string& yaml : broken) {
    EXPECT_NE(FaultInReader(yaml), "") << yaml;
    EXPECT_NE(Refuses(yaml), "") << yaml;
  }
}

TEST_F(ConfigSchema, OfRobotFilesSaysWhatTheirReaderSays) {
  const std::string schema = RobotSchema();
  const auto faults = [](const std::string& yaml, const std::string& where = {}) {
    const test::ScratchFolder folder;
    const std::string file = where.starts_with("/") ? where : folder.Write("robot.yaml", yaml).string();
    const auto nothing = [](const std::string&) { return std::optional<std::string>(); };
    std::string all;
    for (const ConfigError& fault : RobotFile::Check(file, {nothing}).faults) all += fault.what() + std::string("\n");
    return all;
  };
  std::vector<DocumentedFile> files = DocumentedFiles(true);
  EXPECT_GE(files.size(), 1U);
  for (const char* yaml :
       {"components: {a: {type: x}}\nprocesses: {p: , q: {components: [a], env: {A: 1}, cpus: [], nice: -20}}",
        "components: {a: {type: x, params: , remap: , nodes: , essential: false}}\nprocesses:\nprograms:",
        "components: {a: {type: 1, params: {x: [1]}, nodes: {s: {queue: {keep_all: 3}}}}}\ntime: simulated",
        "components: {a: {type: x}}\nprograms: {p: {command: [ls, 1, true], restart: always, priority: 99, memory: "
        "200MB}}",
        "components: {a: {type: x}}\nhosts: {h: , i: {address: 10.0.0.1, port: 7000, home: true},"
        " j: {ssh: 'me@[::1]', hgros: '~/hgros/bin/hgros'}}\n"
        "processes: {p: {host: h}}\nprograms: {q: {command: [ls], host: i}}",
        "components: {a: {type: x}}\nprocesses: {p: {discovery: {domain: d}, channels: {c: {latched: 1}}}}"}) {
    files.push_back({yaml, {}, yaml});
  }
  for (const DocumentedFile& file : files) {
    EXPECT_EQ(faults(file.yaml, file.where), "") << file.where;
    EXPECT_EQ(RefusesBy(schema, file.yaml), "") << file.where;
  }
  const std::string robot = "components: {a: {type: x}}\n";
  const std::vector<std::string> broken{"",
                                        "processes: {}",
                                        "components: {}",
                                        "components: [a]",
                                        "components: {a: x}",
                                        "components: {a: {}}",
                                        "components: {a: {type: [x]}}",
                                        "components: {a: {type: x, parms: {}}}",
                                        "components: {a: {type: x, params: 5}}",
                                        "components: {a: {type: x, remap: {a: 'b c'}}}",
                                        "components: {a: {type: x, remap: [a]}}",
                                        "components: {a: {type: x, nodes: {s: {queue: all}}}}",
                                        "components: {a: {type: x, essential: 'true'}}",
                                        robot + "params: {}",
                                        robot + "processes: [a]",
                                        robot + "processes: {p: {component: [a]}}",
                                        robot + "processes: {p: {components: a}}",
                                        robot + "processes: {p: {components: [a, a]}}",
                                        robot + "processes: {p: {cpus: [1024]}}",
                                        robot + "processes: {p: {nice: 20}}",
                                        robot + "processes: {p: {priority: -1}}",
                                        robot + "processes: {p: {memory: 200Mb}}",
                                        robot + "processes: {p: {memory: 1000}}",
                                        robot + "processes: {p: {env: [A]}}",
                                        robot + "processes: {p: {env: {A: [1]}}}",
                                        robot + "processes: {p: {restart: on_failure}}",
                                        robot + "processes: {p: {essential: 1}}",
                                        robot + "processes: {p: {command: [ls]}}",
                                        robot + "processes: {p: {time: never}}",
                                        robot + "hosts: [a]",
                                        robot + "hosts: {a: {adress: x}}",
                                        robot + "hosts: {a: {address: 'tcp://x'}}",
                                        robot + "hosts: {a: {port: 0}}",
                                        robot + "hosts: {a: {key: short, secret_key_file: /k}}",
                                        robot + "hosts: {a: {secret_key_file: /k}}",
                                        robot + "hosts: {a: {home: 1}}",
                                        robot + "hosts: {a: {ssh: '-v'}}",
                                        robot + "hosts: {a: {ssh: 'a b'}}",
                                        robot + "hosts: {a: {hgros: ''}}",
                                        robot + "programs: {p: }",
                                        robot + "programs: {p: {command: ls}}",
                                        robot + "programs: {p: {command: []}}",
                                        robot + "programs: {p: {command: [[ls]]}}",
                                        robot + "programs: {p: {command: [ls], discovery: {}}}",
                                        robot + "network: 5"};
  for (const std::string& yaml : broken) {
    EXPECT_NE(faults(yaml), "") << yaml;
    EXPECT_NE(RefusesBy(schema, yaml), "") << yaml;
  }
}

TEST_F(ConfigSchema, AllowsNamedSectionsOfAProgram) {
  EXPECT_NE(Refuses("gripper: {width: 3}"), "");
  EXPECT_EQ(Refuses("gripper: {width: 3}", {"gripper"}), "");
  EXPECT_NE(Refuses("griper: {width: 3}", {"gripper"}), "");
}

// What a schema allows at one place, with all alternatives.
struct Allowed {
  std::optional<std::pair<std::int64_t, std::int64_t>> integer;
  bool size = false;
  bool boolean = false;
  std::vector<std::string> choices;
  const Value* object = nullptr;  // With fixed keys.
  const Value* each = nullptr;    // For each value of a map.
  const Value* items = nullptr;
};

// Asks the strict reader at every place of the schema what it wants there: its errors list the keys, choices and bounds
// that it knows.
class ConfigSchemaAndReader : public ConfigSchema {
 protected:
  using Wrap = std::function<std::string(const std::string&)>;

  void Visit(const Value& schema, const std::string& path, const Wrap& wrap) {
    SCOPED_TRACE("at \"" + path + "\"");
    ++places_;
    Allowed allowed;
    Gather(schema, allowed);
    CompareText(allowed, FaultInReader(wrap("zzzz")));
    CompareKeys(allowed, FaultInReader(wrap("{zzzz: 1}")));
    if (allowed.object != nullptr) VisitKeys(*allowed.object, path, wrap);
    if (allowed.each != nullptr) {
      const std::string key = path == ".network.security.servers" ? "'a:1'" : "zz";
      Visit(*allowed.each, path + ".*", [&](const std::string& value) { return wrap("{" + key + ": " + value + "}"); });
    }
    if (allowed.items != nullptr) {
      Visit(*allowed.items, path + "[]", [&](const std::string& value) { return wrap("[" + value + "]"); });
    }
  }
  [[nodiscard]] int places() const { return places_; }

 private:
  void Gather(const Value& schema_or_reference, Allowed& allowed) const {
    const Value& schema = Resolved(schema_or_reference, schema_);
    if (schema.HasMember("anyOf")) {
      for (const Value& one : schema["anyOf"].GetArray()) Gather(one, allowed);
    }
    if (schema.HasMember("minimum")) allowed.integer = {schema["minimum"].GetInt64(), schema["maximum"].GetInt64()};
    if (schema.HasMember("pattern") && std::string(schema["pattern"].GetString()).find("MiB") != std::string::npos) {
      allowed.size = true;
    }
    if (schema.HasMember("type") && schema["type"].IsString()) {
      allowed.boolean = allowed.boolean || std::string(schema["type"].GetString()) == "boolean";
    }
    if (schema.HasMember("enum")) {
      allowed.choices.clear();
      for (const Value& one : schema["enum"].GetArray()) allowed.choices.emplace_back(one.GetString());
    }
    if (schema.HasMember("properties")) {
      allowed.object = &schema;
      EXPECT_TRUE(schema.HasMember("additionalProperties") && schema["additionalProperties"].IsFalse());
    }
    if (schema.HasMember("additionalProperties") && schema["additionalProperties"].IsObject()) {
      allowed.each = &schema["additionalProperties"];
    }
    if (schema.HasMember("items")) allowed.items = &schema["items"];
  }

  static long long NumberIn(const std::string& text) {
    long long number = std::stoll(text);
    for (const std::string_view unit : {"GiB", "MiB", "KiB"}) {
      if (number != std::stoll(text) || text.ends_with(unit)) number *= 1024;
    }
    return number;
  }

  static void CompareText(const Allowed& allowed, const std::string& fault) {
    std::smatch match;
    const bool integer = std::regex_search(fault, match, std::regex("an integer from (-?[0-9]+) to ([0-9]+),"));
    const bool size =
        !integer && std::regex_search(fault, match, std::regex("a size from ([0-9A-Za-z]+) to ([0-9A-Za-z]+),"));
    EXPECT_EQ(integer, allowed.integer && !allowed.size) << fault;
    EXPECT_EQ(size, allowed.size) << fault;
    if ((integer || size) && allowed.integer) {
      EXPECT_EQ(NumberIn(match[1]), allowed.integer->first) << fault;
      EXPECT_EQ(NumberIn(match[2]), allowed.integer->second) << fault;
    }
    EXPECT_EQ(fault.find("true or false") != std::string::npos, allowed.boolean) << fault;
    std::string choices;
    for (const std::string& choice : allowed.choices) {
      choices += (choices.empty() ? "" : ", ") + choice;
      EXPECT_THAT(fault, testing::HasSubstr(choice));
    }
    if (std::regex_search(fault, match, std::regex("one of (.*), but is"))) {
      EXPECT_EQ(match[1], choices) << fault;
    }
  }

  static void CompareKeys(const Allowed& allowed, const std::string& fault) {
    const std::size_t begin = fault.find("Known keys: ");
    if (fault.find("Unknown key \"zzzz\"") == std::string::npos || begin == std::string::npos) {
      EXPECT_EQ(allowed.object, nullptr) << "The reader takes other keys here: " << fault;
      return;
    }
    ASSERT_NE(allowed.object, nullptr) << "config.schema.json lacks the keys of this map: " << fault;
    std::set<std::string> names;
    for (const auto& member : (*allowed.object)["properties"].GetObject()) names.insert(member.name.GetString());
    std::string known = "Known keys: ";
    for (const std::string& name : names) known += (name == *names.begin() ? "" : ", ") + name;
    EXPECT_EQ(fault.substr(begin, known.size() + 1), known + ".") << "config.schema.json and the reader differ.";
  }

  void VisitKeys(const Value& object, const std::string& path, const Wrap& wrap) {
    std::map<std::string, std::string> required;  // With a value that is right.
    if (object.HasMember("required")) {
      for (const Value& name : object["required"].GetArray()) {
        const Value& schema = Resolved(object["properties"][name.GetString()], schema_);
        const bool chosen = schema.HasMember("enum");
        required[name.GetString()] = chosen ? schema["enum"][schema["enum"].Size() - 1].GetString()
                                     : schema.HasMember("minimum") ? std::to_string(schema["minimum"].GetInt64())
                                                                   : "x";
      }
    }
    std::smatch match;
    const std::string fault = FaultInReader(wrap("{}"));
    const bool lacks = std::regex_search(fault, match, std::regex("has no \"([a-z_]+)\""));
    EXPECT_EQ(lacks, !required.empty()) << fault;
    EXPECT_TRUE(!lacks || required.contains(match[1])) << fault;
    for (const auto& member : object["properties"].GetObject()) {
      const std::string name = member.name.GetString();
      EXPECT_TRUE(member.value.HasMember("description")) << name;
      Visit(member.value, path + "." + name, [&](const std::string& value) {
        std::string map = "{";
        for (const auto& [other, good] : required) {
          if (other != name) map += other + ": " + good + ", ";
        }
        return wrap(map + name + ": " + value + "}");
      });
    }
  }

  int places_ = 0;
};

TEST_F(ConfigSchemaAndReader, HaveTheSameKeysChoicesAndBounds) {
  Visit(schema_, "", [](const std::string& value) { return value; });
  EXPECT_GE(places(), 60);
}

}  // namespace
}  // namespace hgros::cli

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "config/config_draft.hpp"
#include "config/config_endpoint.hpp"
#include "hgros/base/names.hpp"
#include "hgros/transport/curve_key_pair.hpp"
#include "hgros/yaml/quoted.hpp"

namespace hgros {
namespace {

using yaml::Section;
using yaml::Settle;
using yaml::Value;

// No error below shows a key: configuration errors end up in logs.

constexpr std::size_t kKeyLength = 40;
constexpr std::string_view kZ85 =  // ZeroMQ RFC 32
    "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";

bool IsKey(std::string_view text) {
  return text.size() == kKeyLength && text.find_first_not_of(kZ85) == std::string_view::npos;
}

void RequireKey(std::string_view key, const Value& value, const std::string& subject = {}) {
  constexpr std::string_view kMend = "A key is 40 characters of Z85, as zmq_curve_keypair() writes them.";
  if (key.size() != kKeyLength) {
    value.Fail(subject + "has " + std::to_string(key.size()) + " characters, but a key has 40", kMend);
  }
  const std::size_t bad = key.find_first_not_of(kZ85);
  if (bad == std::string_view::npos) return;
  value.Fail(subject + "is not a key: character " + std::to_string(bad + 1) + " is not in the Z85 alphabet", kMend);
}

std::string ReadKey(const Value& value) {
  const std::string& key = value.Text("a key of 40 characters");
  RequireKey(key, value);
  return key;
}

class OpenFile {
 public:
  // O_NONBLOCK: if the file is a pipe, open() must not wait for its other end.
  explicit OpenFile(const char* path) : descriptor_(open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {}
  ~OpenFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  [[nodiscard]] int descriptor() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

std::string ReadKeyFile(const Value& value) {
  const std::string& name = value.Text("the path of a file");
  if (name.empty() || name.find('\0') != std::string::npos) value.FailType("the path of a file");
  const std::filesystem::path path = std::filesystem::path(value.position().file).parent_path() / name;
  const OpenFile file(path.c_str());
  struct stat status {};
  if (file.descriptor() < 0 && IsKey(name)) {
    value.Fail("must be the path of a file, but is a key",
               "Put the key into a file of its own, or name it secret_key.");
  }
  if (file.descriptor() < 0 || fstat(file.descriptor(), &status) != 0) {
    value.Fail("names " + yaml::Quoted(path.string()) + ", which cannot be read: " + std::strerror(errno),
               "Check the path. A relative path begins at the folder of this file.");
  }
  if (!S_ISREG(status.st_mode)) value.Fail("names " + yaml::Quoted(path.string()) + ", which is not a regular file");
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    value.Fail("names " + yaml::Quoted(path.string()) + ", which others than the owner may read or write",
               "Run: chmod 600 " + path.string());
  }
  std::string key(kKeyLength + 3, '\0');  // room for a line break, and for one byte more to detect a longer file
  const ssize_t length = read(file.descriptor(), key.data(), key.size());
  if (length < 0)
    value.Fail("names " + yaml::Quoted(path.string()) + ", which cannot be read: " + std::strerror(errno));
  key.resize(static_cast<std::size_t>(length));
  if (key.ends_with('\n')) key.pop_back();
  if (key.ends_with('\r')) key.pop_back();
  if (key.size() > kKeyLength)
    value.Fail("names a file with more than one key in it", "The file must contain only the key.");
  RequireKey(key, value, "names a file that ");
  return key;
}

void ReadAllowedClients(const Value& list, ConfigDraft& draft) {
  if (list.kind() == yaml::Node::Kind::kNull) return;
  std::map<std::string, FilePosition> in_this_list;
  const auto read = [&in_this_list](const Value& item) {
    const auto [first, fresh] = in_this_list.emplace(ReadKey(item), item.position());
    if (!fresh) item.Fail("is a key that the list already has at " + first->second.ToString(), "Keep one of them.");
  };
  const std::vector<Value> items = list.List("a list of public keys");
  for (const Value& item : items) item.faults().Attempt([&] { read(item); });
  draft.allowed_clients.merge(in_this_list);
}

void ReadServers(const Value& map, ConfigDraft& draft) {
  std::map<std::string, FilePosition> in_this_map;
  const auto read = [&](const yaml::Field& field) {
    const std::optional<Endpoint> endpoint = ReadEndpoint(field.key, field.value, EndpointSide::kSubscriber);
    std::string key;  // Stays empty if it is told as a fault.
    field.value.faults().Attempt([&] { key = ReadKey(field.value); });
    if (!endpoint) return;
    const auto [first, fresh] = in_this_map.emplace(endpoint->text, field.key_position);
    if (!fresh) field.value.Fail("already has a key at " + first->second.ToString(), "Keep one of them.");
    const auto [known, added] =
        draft.servers.try_emplace(endpoint->text, yaml::Setting<std::string>{key, field.value.position()});
    if (!added && !key.empty() && known->second.value != key) {
      field.value.Fail("contradicts " + known->second.position.ToString(), "Keep one of the two.");
    }
  };
  const std::vector<yaml::Field> fields = map.Map("a map from subscriber endpoints to public keys");
  for (const yaml::Field& field : fields) field.value.faults().Attempt([&] { read(field); });
}

std::string ReadNoKeyFile(const Value& value) {
  if (value.Text("the path of a file").empty()) value.FailType("the path of a file");
  return {};
}

// A key that cannot be read is told once: the empty one in its place is no further fault.
void ReadKeyInto(ConfigDraft::Maybe<std::string>& setting, const Value& value, std::string (*read)(const Value&)) {
  std::string key;
  value.faults().Attempt([&] { key = read(value); });
  Settle(setting, std::move(key), value);
}

}  // namespace

void ReadSecurity(const Value& value, ConfigDraft& draft) {
  const Section section(value, "a map", {"public_key", "secret_key", "secret_key_file", "allowed_clients", "servers"});
  const auto secret_key = section.Find("secret_key");
  const auto secret_key_file = section.Find("secret_key_file");
  if (secret_key && secret_key_file) {
    secret_key_file->Fail("stands beside secret_key at " + secret_key->position().ToString(), "Keep one of the two.");
  }
  section.Read("public_key", [&](const Value& key) { ReadKeyInto(draft.public_key, key, ReadKey); });
  section.Read("secret_key", [&](const Value& key) { ReadKeyInto(draft.secret_key, key, ReadKey); });
  section.Read("secret_key_file", [&](const Value& file) {
    ReadKeyInto(draft.secret_key, file, draft.read_key_files ? ReadKeyFile : ReadNoKeyFile);
  });
  section.Read("allowed_clients", [&](const Value& clients) { ReadAllowedClients(clients, draft); });
  section.Read("servers", [&](const Value& servers) { ReadServers(servers, draft); });
}

void CheckSecurity(const ConfigDraft& draft) {
  if (!draft.secret_key) {
    constexpr std::string_view kWhat = "There is no secret key, so nothing would be encrypted.";
    constexpr std::string_view kMend = "Add network.security.secret_key_file, or remove this.";
    const auto report = [&](const FilePosition& at) { draft.faults.Report(ConfigError(kWhat, at, kMend)); };
    if (draft.public_key) return report(draft.public_key->position);
    if (!draft.allowed_clients.empty()) return report(draft.allowed_clients.begin()->second);
    if (!draft.servers.empty()) return report(draft.servers.begin()->second.position);
    return;
  }
  if (!draft.public_key) {
    draft.faults.Report(ConfigError("The secret key has no public key beside it.", draft.secret_key->position,
                                    "Add network.security.public_key."));
  }
  // Empty: the key could not be read, which is told already.
  if (draft.public_key && !draft.public_key->value.empty() && !draft.secret_key->value.empty()) {
    std::string own;
    try {
      own = PublicCurveKeyOf(draft.secret_key->value);
    } catch (const Error& error) {  // Some texts of its length and alphabet are no key.
      draft.faults.Report(ConfigError(error.what(), draft.secret_key->position, {}));
    }
    if (!own.empty() && own != draft.public_key->value) {
      draft.faults.Report(ConfigError("The public key does not belong to the secret key.", draft.public_key->position,
                                      "The public key of that secret key is " + own));
    }
  }
  std::vector<std::string> known;
  for (const auto& [endpoint, key] : draft.servers) known.push_back(endpoint);
  for (const auto& [endpoint, subscriber] : draft.subscribers) {
    if (draft.servers.contains(endpoint)) continue;
    const std::string nearest = NearestName(endpoint, known);
    draft.faults.Report(ConfigError(
        "Encryption is on, but network.security.servers has no key for \"" + endpoint + "\".", subscriber.position,
        "Add the public key of the publisher." +
            (nearest.empty() ? std::string() : " The nearest endpoint there is \"" + nearest + "\".")));
  }
}

}  // namespace hgros

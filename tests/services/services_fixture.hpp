#pragma once

#include "session/domain_fixture.hpp"

namespace hgros::test {

struct Sum {
  int a = 0;
  int b = 0;
};
struct Total {
  int value = 0;
};

constexpr auto kLong = std::chrono::seconds(60);  // Longer than any test waits.
using Kind = CallFailure::Kind;

inline Total Add(const Sum& sum) { return {sum.a + sum.b}; }

/// The configurations of the two sides of a service.
struct Places {
  std::string name;
  bool apart = true;
  std::string first;
  std::string second;
};

inline Places PlacesOf(const std::string& name) {
  const std::string alone = "discovery: {local: false}\n";
  if (name == "pointer") return {name, false, "", ""};
  if (name == "sharedmemory") return {name, true, "", ""};
  if (name == "ipc") {
    static const Bus bus;
    static int number = 0;
    const std::string a = "a" + std::to_string(++number);
    const std::string b = "b" + std::to_string(number);
    return {name, true, bus.Both(a, b) + alone, bus.Both(b, a) + alone};
  }
  // Each side gets the endpoint of the other.
  const std::string tcp = "network: {publisher: {ip: 'tcp://127.0.0.1:*'}}\n" + alone;
  return {name, true, tcp, tcp};
}

/// Two sessions, or one that is both sides.
class Pair {
 public:
  explicit Pair(const Places& places, const std::string& server_yaml = {}, const std::string& caller_yaml = {}) {
    first_.emplace(places.first + server_yaml, "server");
    if (!places.apart) return;
    second_.emplace(places.second + caller_yaml, "caller");
    if (places.name != "tcp") return;
    server().AddSubscriberEndpoint({caller().PublisherEndpoints().at(0), {}, true});
    caller().AddSubscriberEndpoint({server().PublisherEndpoints().at(0), {}, true});
  }
  [[nodiscard]] Session& server() { return *first_->session; }
  [[nodiscard]] Session& caller() { return second_ ? *second_->session : *first_->session; }
  void EndServer() { first_.reset(); }
  void EndCaller() { second_.reset(); }

 private:
  std::optional<Robot> first_;
  std::optional<Robot> second_;
};

/// The places are those of the parameter: pointer, sharedmemory, ipc or tcp.
class PairFixture : public DomainFixture, public testing::WithParamInterface<std::string> {
 protected:
  std::optional<Pair> pair{std::in_place, PlacesOf(GetParam())};
};

}  // namespace hgros::test

#include "config/config_endpoint.hpp"

#include <arpa/inet.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "hgros/base/error.hpp"
#include "hgros/base/names.hpp"
#include "hgros/yaml/quoted.hpp"

namespace hgros {
namespace {

using yaml::Quoted;

constexpr std::size_t kMaxIpcPath = sizeof(sockaddr_un::sun_path) - 1;
constexpr std::size_t kMaxHostName = 253;
constexpr std::string_view kNameCharacters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_";

std::string Lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
  return out;
}

bool OnlyOf(std::string_view text, std::string_view characters) {
  return text.find_first_not_of(characters) == std::string_view::npos;
}

// The canonical spelling of an address; empty if it is not an address.
std::string Canonical(int family, const std::string& address) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (inet_pton(family, address.c_str(), bytes.data()) != 1) return {};
  return inet_ntop(family, bytes.data(), text.data(), text.size());
}

// Reads one endpoint. Throws Error with a sentence that lacks its subject, and an example.
class EndpointReader {
 public:
  EndpointReader(std::string_view text, EndpointSide side, bool may_be_off)
      : text_(text), side_(side), may_be_off_(may_be_off) {}

  Endpoint Read() const {
    if (text_.empty()) Fail("is empty", Example());
    for (const char c : text_) {
      if (static_cast<unsigned char>(c) <= 0x20 || c == 0x7f) {
        Fail("is " + Quoted(text_) + ", which has a space or control character", "Remove it.");
      }
    }
    const std::size_t separator = text_.find("://");
    if (separator == std::string_view::npos) return ReadTcp(text_);
    const std::string scheme = Lower(text_.substr(0, separator));
    const std::string_view rest = text_.substr(separator + 3);
    if (scheme == "tcp") return ReadTcp(rest);
    if (scheme == "ipc") return ReadIpc(rest);
    const std::array<std::string, 2> known = {"tcp", "ipc"};
    const std::string nearest = scheme.size() <= 64 ? NearestName(scheme, known) : std::string();
    Fail("is " + Quoted(text_) + ", but there is no scheme " + Quoted(scheme),
         (nearest.empty() ? "" : "Did you mean \"" + nearest + "\"? ") + std::string("Known schemes: ipc, tcp."));
  }

 private:
  [[noreturn]] static void Fail(const std::string& predicate, const std::string& mend) {
    throw Error(predicate, {}, mend);
  }

  bool publisher() const { return side_ == EndpointSide::kPublisher; }

  std::string Example() const {
    return std::string("Write it as in ") + (publisher() ? "\"tcp://*:5553\"" : "\"tcp://192.168.1.7:5553\"") +
           (may_be_off_ ? ", or \"x\" to switch it off." : ".");
  }

  Endpoint ReadTcp(std::string_view rest) const {
    const std::size_t bracket = rest.starts_with('[') ? rest.find(']') : std::string_view::npos;
    if (rest.starts_with('[') && bracket == std::string_view::npos) {
      Fail("is " + Quoted(text_) + ", whose bracket is not closed", "Write it as in \"tcp://[::1]:5553\".");
    }
    const std::size_t colon = rest.find(':', bracket == std::string_view::npos ? 0 : bracket);
    if (colon == std::string_view::npos) Fail("is " + Quoted(text_) + ", which has no port", Example());
    const std::string_view host = rest.substr(0, colon);
    const std::string_view port = rest.substr(colon + 1);
    if (port.find(':') != std::string_view::npos) {
      Fail("is " + Quoted(text_) + ", which has more than one colon before the port",
           "Write an IPv6 address in brackets, as in \"tcp://[::1]:5553\".");
    }
    const std::string address = bracket == std::string_view::npos ? ReadHost(host) : ReadIpv6(host);
    const std::optional<int> number = ReadPort(port);
    return {"tcp://" + address + ":" + (number ? std::to_string(*number) : "*"), number};
  }

  std::optional<int> ReadPort(std::string_view port) const {
    if (port.empty()) Fail("is " + Quoted(text_) + ", which has no port", Example());
    if (port == "*") port = "0";
    const bool digits = OnlyOf(port, "0123456789");
    const std::string number(port.substr(std::min(port.find_first_not_of('0'), port.size())));
    if (!digits || number.size() > 5 || (!number.empty() && std::stoi(number) > 65535)) {
      Fail("is " + Quoted(text_) + ", whose port " + Quoted(port) + " is not valid",
           "A port is a number from 1 to 65535.");
    }
    if (!number.empty()) return std::stoi(number);
    if (!publisher()) {
      Fail("is " + Quoted(text_) + ", whose port is a wildcard", "A subscriber needs the publisher's port.");
    }
    return std::nullopt;
  }

  std::string ReadIpv6(std::string_view bracketed) const {
    if (!bracketed.ends_with(']')) {
      Fail("is " + Quoted(text_) + ", where no port follows the bracket", "Write it as in \"tcp://[::1]:5553\".");
    }
    const std::string_view inner = bracketed.substr(1, bracketed.size() - 2);
    const std::string_view zone = inner.substr(std::min(inner.find('%'), inner.size()));
    const std::string address = Canonical(AF_INET6, std::string(inner.substr(0, inner.size() - zone.size())));
    if (address.empty() || zone == "%" ||
        !OnlyOf(zone.substr(std::min<std::size_t>(1, zone.size())), kNameCharacters)) {
      Fail("is " + Quoted(text_) + ", but " + Quoted(inner) + " is not an IPv6 address",
           "Write it as in \"tcp://[::1]:5553\".");
    }
    if (address == "::" && !publisher()) FailWildcard();
    return "[" + address + std::string(zone) + "]";
  }

  std::string ReadHost(std::string_view host) const {
    if (host.empty()) Fail("is " + Quoted(text_) + ", which has no host", Example());
    if (host == "*" || host == "0.0.0.0") {
      if (!publisher()) FailWildcard();
      return "*";
    }
    if (OnlyOf(host, "0123456789.")) {
      const std::string address = Canonical(AF_INET, std::string(host));
      if (!address.empty()) return address;
      Fail("is " + Quoted(text_) + ", but " + Quoted(host) + " is not an IPv4 address",
           "Write four numbers from 0 to 255, as in 192.168.1.7.");
    }
    if (!OnlyOf(host, kNameCharacters) || host.front() == '-' || host.front() == '.' || host.size() > kMaxHostName) {
      Fail("is " + Quoted(text_) + ", but " + Quoted(host) + " is not a host name", Example());
    }
    // ZeroMQ binds to addresses and interfaces only; an interface's name is case-sensitive.
    if (publisher()) return Lower(host) == "localhost" ? "127.0.0.1" : std::string(host);
    return Lower(host);
  }

  [[noreturn]] void FailWildcard() const {
    Fail("is " + Quoted(text_) + ", but a subscriber cannot connect to every address",
         "Name the publisher's host, as in \"tcp://192.168.1.7:5553\".");
  }

  Endpoint ReadIpc(std::string_view path) const {
    if (path.size() > kMaxIpcPath) {
      Fail("is " + Quoted(text_) + ", whose path has " + std::to_string(path.size()) + " bytes",
           "A socket's path has " + std::to_string(kMaxIpcPath) + " bytes at most.");
    }
    if (path.starts_with('@') && path.size() > 1) return {"ipc://" + std::string(path), std::nullopt};
    const std::string normal = std::filesystem::path(path).lexically_normal().string();
    if (!normal.starts_with('/') || normal.ends_with('/')) {
      Fail("is " + Quoted(text_) + ", which is not an absolute path of a file",
           "Write it as in \"ipc:///run/robot/bus\", or \"ipc://@robot\" for an abstract name.");
    }
    return {"ipc://" + normal, std::nullopt};
  }

  std::string_view text_;
  EndpointSide side_;
  bool may_be_off_;
};

}  // namespace

std::optional<Endpoint> ReadEndpoint(std::string_view text, const yaml::Value& value, EndpointSide side) {
  if (text == "x") return std::nullopt;
  try {
    return EndpointReader(text, side, true).Read();
  } catch (const Error& fault) {
    value.Fail(fault.sentence(), fault.mend());
  }
}

std::optional<Endpoint> ReadEndpoint(const yaml::Value& value, EndpointSide side) {
  return ReadEndpoint(value.Text("an endpoint as a text"), value, side);
}

void RequireEndpoint(std::string_view endpoint, EndpointSide side) {
  try {
    (void)EndpointReader(endpoint, side, false).Read();
  } catch (const Error& fault) {
    throw Error("The endpoint " + fault.sentence() + ".", {}, fault.mend());
  }
}

}  // namespace hgros

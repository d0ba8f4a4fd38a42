#include "transport/zmq/curve.hpp"

#include <array>
#include <string_view>
#include <vector>

#include "hgros/base/error.hpp"
#include "hgros/base/log.hpp"
#include "hgros/transport/zmq_transport.hpp"

namespace hgros {

CurveKeyPair GenerateCurveKeyPair() {
  std::array<char, 41> public_key{};
  std::array<char, 41> secret_key{};
  do {
    if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0) {
      throw Error("ZeroMQ was built without CURVE: no keys can be made.", {}, "Install a libzmq with libsodium.");
    }
  } while (std::string_view(public_key.data()).find("${") != std::string_view::npos);
  return {public_key.data(), secret_key.data()};
}

std::string PublicCurveKeyOf(const std::string& secret_key) {
  std::array<char, 41> public_key{};
  if (secret_key.size() + 1 != public_key.size() || zmq_curve_public(public_key.data(), secret_key.c_str()) != 0) {
    throw Error("The secret key is not a CURVE key, or ZeroMQ was built without CURVE.");
  }
  return public_key.data();
}

}  // namespace hgros

namespace hgros::zmq {
namespace {

constexpr std::size_t kKeyBytes = 32;
constexpr std::size_t kKeyCharacters = 40;
constexpr const char* kZapEndpoint = "inproc://zeromq.zap.01";
constexpr std::string_view kDomain = "hgros";

/// The 32 bytes of a key. The error names `whose` key it is, but never contains the key.
std::string DecodeKey(const std::string& text, std::string_view whose) {
  std::array<std::uint8_t, kKeyBytes> key{};
  if (text.size() != kKeyCharacters || zmq_z85_decode(key.data(), text.c_str()) == nullptr) {
    throw Error("The " + std::string(whose) + " key is not a CURVE key.", {},
                "A key is 40 characters of Z85, as GenerateCurveKeyPair() makes them.");
  }
  return std::string(reinterpret_cast<const char*>(key.data()), key.size());
}

std::string EncodeKey(std::string_view bytes) {
  std::array<char, kKeyCharacters + 1> text{};
  zmq_z85_encode(text.data(), reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  return text.data();
}

}  // namespace

std::string KeyText(const std::string& key, std::string_view whose) { return EncodeKey(DecodeKey(key, whose)); }

void SecureServer(Socket& socket, const ZmqSecurity& security) {
  socket.Set(ZMQ_CURVE_SERVER, 1);
  socket.Set(ZMQ_CURVE_SECRETKEY, std::string_view(DecodeKey(security.own.secret_key, "own secret")));
  socket.Set(ZMQ_ZAP_DOMAIN, kDomain);
}

void SecureClient(Socket& socket, const ZmqSecurity& security, const std::string& server_key) {
  socket.Set(ZMQ_CURVE_SERVERKEY, std::string_view(DecodeKey(server_key, "server")));
  socket.Set(ZMQ_CURVE_PUBLICKEY, std::string_view(DecodeKey(security.own.public_key, "own public")));
  socket.Set(ZMQ_CURVE_SECRETKEY, std::string_view(DecodeKey(security.own.secret_key, "own secret")));
}

AdmissionDesk::AdmissionDesk(Context& context, const ZmqSecurity& security, Log& log)
    : socket_(context, ZMQ_ROUTER), fd_(-1), log_(log) {
  for (const auto& key : security.allowed_clients) allowed_.insert(DecodeKey(key, "allowed client's"));
  if (const int error = socket_.Bind(kZapEndpoint); error != 0) {
    throw Error(std::string("Cannot check keys: ") + zmq_strerror(error) + ".");
  }
  fd_ = socket_.Fd();
}

void AdmissionDesk::Serve() {
  Message frame;
  while (socket_.Receive(frame)) {
    // Return address, empty, version, request, domain, address, identity, mechanism, key.
    std::vector<Message> frames;
    frames.push_back(std::move(frame));
    while (frames.back().more()) {
      Message next;
      if (!socket_.Receive(next)) break;
      frames.push_back(std::move(next));
    }
    frame = Message();
    if (frames.size() < 8) continue;
    const auto text = [&](std::size_t i) { return AsText(frames[i].bytes()); };
    const bool welcome = frames.size() == 9 && text(7) == "CURVE" && allowed_.contains(text(8));
    if (!welcome) {
      refused_.fetch_add(1, std::memory_order_relaxed);
      const std::string address(text(5).substr(0, 64));
      log_.WriteLimited(LogLevel::kWarning, "zmq refused",
                        "Refused a connection from " + address + ": its key is not among the allowed ones.");
    }
    const std::string version(text(2));
    const std::string request(text(3));
    socket_.Send(frames[0], true);
    socket_.Send(std::string_view(), true);
    socket_.Send(version, true);
    socket_.Send(request, true);
    socket_.Send(welcome ? "200" : "400", true);
    socket_.Send(welcome ? "OK" : "not allowed", true);
    socket_.Send(welcome ? EncodeKey(text(8)) : std::string(), true);
    socket_.Send(std::string_view(), false);
  }
}

}  // namespace hgros::zmq

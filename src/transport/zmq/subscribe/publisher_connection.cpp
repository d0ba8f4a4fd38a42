#include "transport/zmq/subscribe/publisher_connection.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "hgros/base/error.hpp"
#include "hgros/base/system_limits.hpp"
#include "transport/zmq/control.hpp"
#include "transport/zmq/curve.hpp"
#include "transport/zmq/endpoint.hpp"

namespace hgros::zmq {
namespace {

constexpr std::uint64_t kEncryptionBytes = 1024;  // More than CURVE adds to a frame.
constexpr int kReconnectMs = 100;
constexpr int kReconnectMaxMs = 1000;
// The kernel repeats an attempt that gets no answer ever more rarely. A cable that is back must not wait for that.
constexpr int kConnectMs = 2000;
constexpr auto kBetweenReports = std::chrono::milliseconds(100);  // Each outage is reported.
constexpr auto kSessionsPeriod = std::chrono::seconds(10);
constexpr auto kGivenUpAfter = std::chrono::milliseconds(100);

// The failure of a handshake that says more about its cause; 0: none.
int MoreSpecific(int one, int other) {
  for (const int failure : {ZMQ_EVENT_HANDSHAKE_FAILED_AUTH, ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL}) {
    if (one == failure || other == failure) return failure;
  }
  return other;
}

bool IsAllowed(const ZmqSecurity& security, const std::string& key) {
  return std::ranges::any_of(security.allowed_clients,
                             [&](const auto& one) { return KeyText(one, "allowed client's") == key; });
}

}  // namespace

PublisherConnection::PublisherConnection(SharedState& shared, const SubscribeEndpoint& endpoint)
    : shared_(shared),
      endpoint_(FullEndpoint(endpoint.endpoint)),
      server_key_(shared.options.security ? KeyText(endpoint.server_key, "server") : std::string()),
      trusted_(shared.options.security && IsAllowed(*shared.options.security, server_key_)),
      socket_(shared.context, ZMQ_XSUB),
      monitor_(shared.context, ZMQ_PAIR),
      logs_(!endpoint.on_event) {
  SetFamily(socket_, endpoint_);
  socket_.Set(ZMQ_SNDHWM, 0);
  socket_.Set(ZMQ_RCVHWM, 0);
  socket_.Set(ZMQ_RECONNECT_IVL, kReconnectMs);
  socket_.Set(ZMQ_RECONNECT_IVL_MAX, kReconnectMaxMs);
  socket_.Set(ZMQ_CONNECT_TIMEOUT, kConnectMs);
  socket_.Set(ZMQ_MAXMSGSIZE, static_cast<std::int64_t>(shared.options.max_message_bytes + kEncryptionBytes));
  socket_.Set(ZMQ_TCP_KEEPALIVE, 1);
  socket_.Set(ZMQ_TCP_MAXRT, static_cast<int>(shared.options.peer_timeout.count()));
  if (shared.options.security) SecureClient(socket_, *shared.options.security, endpoint.server_key);

  const std::string monitored = "inproc://monitor-" + std::to_string(RandomId());
  if (zmq_socket_monitor(socket_.raw(), monitored.c_str(),
                         ZMQ_EVENT_CONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED |
                             ZMQ_EVENT_CONNECT_RETRIED | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL |
                             ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) != 0) {
    throw Error(std::string("Cannot watch the connection to ") + endpoint_ + ": " + zmq_strerror(zmq_errno()) + ".");
  }
  if (const int error = monitor_.Connect(monitored); error != 0) {
    throw Error(std::string("Cannot watch the connection to ") + endpoint_ + ": " + zmq_strerror(error) + ".");
  }
  SubscribeTopic(ControlTopic(shared.self.info.id), true);
  if (const int error = socket_.Connect(endpoint_); error != 0) {
    throw Error("Cannot subscribe at " + endpoint_ + ": " + zmq_strerror(error) + ".", {},
                "Write it as tcp://address:port or ipc:///path.");
  }
  fd_ = socket_.Fd();
  monitor_fd_ = monitor_.Fd();
}

void PublisherConnection::SubscribeTopic(std::string topic, bool subscribe) {
  topic.insert(topic.begin(), subscribe ? '\1' : '\0');
  socket_.Send(topic, false);
}

void PublisherConnection::Send(const wire::Control& control) {
  const std::string frame = UpstreamFrame(control);
  socket_.Send(frame, false);
  too_much_unread_ = unread_.Add(frame.size()) || too_much_unread_;
}

bool PublisherConnection::ReadMonitor() {
  bool ended = false;
  Message event;
  Message address;
  while (monitor_.Receive(event)) {
    if (event.more()) monitor_.Receive(address);
    std::uint16_t what = 0;
    std::int32_t value = 0;
    if (event.bytes().size() < sizeof what + sizeof value) continue;
    std::memcpy(&what, event.bytes().data(), sizeof what);
    std::memcpy(&value, event.bytes().data() + sizeof what, sizeof value);
    if (what == ZMQ_EVENT_CONNECTED) {
      NoteConnection(value);
    } else if (what == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
      connected_ = true;
      welcomed_ = false;
      connected_since_ = std::chrono::steady_clock::now();
      unreached_since_.reset();
      handshake_failure_ = 0;
      if (std::exchange(reported_, false)) {
        shared_.log.WriteLimited(LogLevel::kWarning, "zmq reached " + endpoint_, "Connected to " + endpoint_ + ".",
                                 kBetweenReports);
      }
    } else if (what == ZMQ_EVENT_DISCONNECTED) {
      NoteConnection(-1);
      given_up_since_ = std::chrono::steady_clock::now();
      if (connected_) unreached_since_ = given_up_since_;
      connected_ = false;
      plain_ = false;
      ended = failed_ = true;
    } else if (what == ZMQ_EVENT_CONNECT_RETRIED) {
      given_up_since_.reset();
      failed_ = true;
    } else {
      handshake_failure_ = MoreSpecific(handshake_failure_, what);
    }
  }
  return ended;
}

void PublisherConnection::NoteConnection(int fd) noexcept {
  new_connection_ = tcp_ = fd;
  unread_.Watch(fd);
  progress_ = {};
  sessions_ = 0;
}

bool PublisherConnection::NoteSession() noexcept {
  const auto now = std::chrono::steady_clock::now();
  if (now - sessions_since_ >= kSessionsPeriod) {
    sessions_since_ = now;
    sessions_ = 0;
  }
  return ++sessions_ <= kMostSessions;
}

void PublisherConnection::SetWelcomed() noexcept {
  welcomed_ = true;
  plain_ = false;
}

void PublisherConnection::SetConnected() noexcept {
  connected_ = true;
  unreached_since_.reset();
}

bool PublisherConnection::TurnPlain(SteadyTime now) {
  if (!connected_ || welcomed_ || plain_ || now - connected_since_ < shared_.options.plain_after) return false;
  plain_ = true;
  return true;
}

void PublisherConnection::Tick(SteadyTime now) {
  if (unreached_since_ && now - *unreached_since_ >= shared_.options.unreachable_after) {
    unreached_since_.reset();
    reported_ = logs_;
    if (logs_) LogUnreachable();
  }
  if (given_up_since_ && now - *given_up_since_ >= kGivenUpAfter && now >= paused_until_) {
    given_up_since_.reset();
    socket_.Disconnect(endpoint_);
    if (const int error = socket_.Connect(endpoint_); error != 0) {
      shared_.log.WriteLimited(LogLevel::kError, "zmq subscribe " + endpoint_,
                               "Cannot subscribe at " + endpoint_ + " again: " + zmq_strerror(error) + ".");
    }
  }
}

void PublisherConnection::LogUnreachable() {
  const auto say = [&log = shared_.log, endpoint = endpoint_,
                    since = std::to_string(shared_.options.unreachable_after.count())](std::string_view why) {
    log.WriteLimited(LogLevel::kWarning, "zmq unreached " + endpoint,
                     "No connection to " + endpoint + " for " + since + " ms: " + std::string(why), kBetweenReports);
  };
  if (handshake_failure_ == 0 && FreeDescriptors(1) == 0) {
    return say("this process can open no more files. Raise the limit (ulimit -n).");
  }
  std::string_view why = "is the other program running, is the port right, and does it bind that address?";
  if (handshake_failure_ == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH) {
    why = "it refuses our key; add our public key to its `allowed_clients`.";
  } else if (handshake_failure_ == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL) {
    why = shared_.options.security
              ? "the program there closes the connection at once: it has another key than the one we have for it (see "
                "`network.security.servers`), does not encrypt, or can open no more files."
              : "the program there closes the connection at once: it can open no more files, asks for keys, or is not "
                "ZeroMQ. Its log may say more.";
  } else if (handshake_failure_ != 0 && shared_.options.security) {
    // A wrong key and a missing key look the same here: the event depends on which side notices it first.
    why =
        "the program there has another key than the one we have for it, or does not encrypt; set the publisher's "
        "public key for this endpoint in `network.security.servers`, and give the publisher a `secret_key`.";
  } else if (handshake_failure_ != 0) {
    why = "the program there asks for keys, or is not ZeroMQ; set a `secret_key` here, or check the port.";
  }
  const std::string host = handshake_failure_ == 0 ? HostNameOf(endpoint_) : std::string();
  if (host.empty()) return say(why);
  // An earlier look-up that still runs will report the fault.
  if (lookup_.valid() && lookup_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  try {
    lookup_ = std::async(std::launch::async, [say, why, host] {
      const std::string fault = ResolveFault(host);
      say(fault.empty() ? std::string(why)
                        : "the host \"" + host + "\" has no address (" + fault +
                              "). Check the spelling, or add it to /etc/hosts or the name server.");
    });
  } catch (const std::system_error&) {  // No thread can be made.
    say(why);
  }
}

std::optional<SteadyTime> PublisherConnection::Deadline() const {
  if (unreached_since_) return *unreached_since_ + shared_.options.unreachable_after;
  if (!connected_ || welcomed_ || plain_) return std::nullopt;
  return connected_since_ + shared_.options.plain_after;
}

bool PublisherConnection::IsLeftAlone(SteadyTime now, SteadyTime heard) {
  if (!shared_.options.security || !connected_) return false;
  if (welcomed_ && now - heard > 2 * shared_.options.peer_timeout) return true;
  const auto progress = ProgressOf(tcp_, true);
  if (!progress) return false;
  const Progress before = std::exchange(progress_, *progress);
  if (!progress->unread || !before.unread || progress->read != before.read) reading_at_ = now;
  return now - reading_at_ > kLeftAloneAfter;
}

void PublisherConnection::Abort(std::chrono::milliseconds pause) {
  socket_.Disconnect(endpoint_);
  connected_ = false;
  NoteConnection(-1);
  given_up_since_ = std::chrono::steady_clock::now();
  paused_until_ = *given_up_since_ + pause;
  unreached_since_ = paused_until_;
}

void PublisherConnection::Close(int linger_ms) {
  zmq_socket_monitor(socket_.raw(), nullptr, 0);
  socket_.Close(linger_ms);
  monitor_.Close(0);
}

}  // namespace hgros::zmq

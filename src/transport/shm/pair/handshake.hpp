#pragma once

#include <memory>
#include <string>
#include <vector>

#include "transport/shm/pair/pair_table.hpp"
#include "transport/shm/shm_publisher.hpp"
#include "transport/shm/shm_session.hpp"

namespace hgros::shm {

/// How two sessions greet each other, and which of several connections between them stays.
///
/// Two sessions may connect to each other at the same time, and both connections may be half made. The session with
/// the smaller id chooses the first connection whose hello it reads. The other session begins nothing before it gets
/// the choice. No session ends the connection of another living process by using its id.
///
/// Thread safety: the socket thread only. Invariants: a pair is greeted exactly when both of the peer's pages and its
/// bell are open.
class Handshake {
 public:
  Handshake(ShmSession& session, PairTable& pairs, ShmPublisher& publisher, SessionBell& bell)
      : session_(session), pairs_(pairs), publisher_(publisher), bell_(bell) {}

  /// A frame before the greeting is no longer than this.
  static constexpr std::size_t kMaxHelloBytes = 64 * 1024;

  void SayHello(Pair& pair);

  struct Outcome {
    enum class Step {
      kBegin,   ///< The pair begins.
      kWait,    ///< The peer decides which connection stays.
      kRefuse,  ///< The pair ends, for `reason`.
      kLie,     ///< The peer has sent something impossible: `reason`.
    };
    Step step = Step::kWait;
    std::string reason = {};
    std::vector<std::shared_ptr<Pair>> replaced = {};  ///< Pairs that end, because this one takes their place.
  };
  [[nodiscard]] Outcome OnHello(Pair& pair, PairSocket::Frame& frame);
  [[nodiscard]] Outcome OnWelcome(const Pair& pair) const;

 private:
  [[nodiscard]] std::string OpenPages(Pair& pair, const wire::PairHello& hello, PairSocket::Frame& frame);
  [[nodiscard]] Outcome CompareWithOthers(const Pair& pair) const;

  ShmSession& session_;
  PairTable& pairs_;
  ShmPublisher& publisher_;
  SessionBell& bell_;
};

}  // namespace hgros::shm

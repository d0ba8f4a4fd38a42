#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "support/await.hpp"
#include "transport/agreement.hpp"
#include "transport/shm/memory/bell.hpp"
#include "transport/shm/memory/layout.hpp"
#include "transport/shm/memory/memory.hpp"
#include "transport/shm/pair/pair_socket.hpp"

namespace hgros::shm {

/// The other side of a pair, made by hand: it can send and write anything.
class FalsePeer {
 public:
  /// Connects to the session at `place`, and claims to be the session `id`.
  explicit FalsePeer(const std::string& place, SessionId id = SessionId::Random())
      : id_(id),
        bell_(Page<BellPage>(kBellMagic)),
        lane_(Page<LanePage>(kLaneMagic)),
        slip_(Page<SlipPage>(kSlipMagic)) {
    std::string fault;
    socket_ = std::make_unique<PairSocket>(std::make_shared<const Handle>(ConnectTo(place, fault)), 1 << 28);
  }

  template <class PageKind>
  static Segment Page(std::uint32_t magic) {
    Segment made = MakeSegment("hgros-false", sizeof(PageKind), Access::kEverybody, Pages::kOnTouch);
    made.mapping->as<PageKind>().magic = magic;
    made.mapping->as<PageKind>().version = kLayoutVersion;
    return made;
  }
  static std::shared_ptr<const Handle> Copy(const Segment& segment) {
    return std::make_shared<const Handle>(dup(segment.handle.fd()));
  }

  [[nodiscard]] SessionId id() const { return id_; }
  [[nodiscard]] BellPage& bell() const { return bell_.mapping->as<BellPage>(); }
  [[nodiscard]] LanePage& lane() const { return lane_.mapping->as<LanePage>(); }
  [[nodiscard]] SlipPage& slip() const { return slip_.mapping->as<SlipPage>(); }
  [[nodiscard]] PairSocket& socket() const { return *socket_; }
  void Hang() { socket_.reset(); }

  // Each has another name, so that each of its faults is logged.
  [[nodiscard]] wire::PairMessage Hello() const {
    wire::PairMessage said;
    auto& hello = *said.mutable_hello();
    hello.set_session(id_.value);
    WriteFacts(OwnFacts(id_, "false-" + id_.ToString()), *hello.mutable_facts());
    hello.mutable_facts()->set_incarnation(incarnation);
    hello.set_layout(kLayoutVersion);
    hello.set_bell_number(3);
    return said;
  }
  [[nodiscard]] PairSocket::Handles Handles() const { return {Copy(bell_), Copy(lane_), Copy(slip_)}; }
  void Greet() { Say(Hello(), Handles()); }
  /// Greets. If our id is the smaller one, also chooses this connection.
  bool Meet() {
    Greet();
    SessionId theirs;
    const bool met = ReadUntil([&theirs](const wire::PairMessage& message) {
      theirs = SessionId{message.hello().session()};
      return message.has_hello();
    });
    wire::PairMessage welcome;
    welcome.mutable_welcome();
    if (met && id_.value < theirs.value) Say(welcome);
    return met;
  }
  void Say(const wire::PairMessage& message, const PairSocket::Handles& handles = {}) {
    socket_->Send(message, handles);
  }
  void SayRaw(const std::string& bytes) const {
    [[maybe_unused]] const auto sent = send(socket_->handle()->fd(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  /// Sends a heartbeat and rings the bell.
  void Ring() const {
    lane().heartbeat.fetch_add(1);
    slip().heartbeat.fetch_add(1);
    if (their_bell_) their_bell_->Ring();
  }

  /// Reads until `done`; false if the other side ends first or takes too long.
  bool ReadUntil(const std::function<bool(const wire::PairMessage&)>& done) {
    PairSocket::Frame frame;
    bool found = false;
    (void)test::Await([&] {
      Ring();
      (void)socket_->Flush();
      for (;;) {
        const auto read = socket_->Receive(frame);
        if (read == PairSocket::Read::kNothing || read == PairSocket::Read::kMore) return false;
        if (read != PairSocket::Read::kFrame) {
          ended_ = true;
          return true;
        }
        Note(frame);
        if (done(frame.message)) return found = true;
      }
    });
    return found;
  }
  [[nodiscard]] bool ReadUntil(wire::PairMessage::WhatCase what) {
    return ReadUntil([what](const wire::PairMessage& message) { return message.what_case() == what; });
  }
  /// True if the other side ends the connection: it sends `bye`, or closes the socket when it holds no more messages.
  [[nodiscard]] bool IsEnded() { return ReadUntil(wire::PairMessage::kBye) || ended_; }

  /// Greets, and publishes the channel `lies`. False if the other side does not ask for it.
  bool Publish(std::uint32_t messages = 4, std::uint64_t bytes = 10'000) {
    if (!Meet()) return false;
    if (!ReadUntil([](const auto& message) { return message.wish().wanted().channel() == "lies"; })) return false;
    wire::PairMessage said;
    auto& granted = *said.mutable_granted();
    granted.set_link(wish.link());
    *granted.mutable_offered() = wish.wanted();
    granted.set_credit_messages(messages);
    granted.set_credit_bytes(bytes);
    Say(said);
    return true;
  }
  /// Subscribes to the channel. False if the other side does not grant it.
  bool Subscribe(const std::string& channel, const TypeInfo& type, std::uint32_t messages = 4,
                 std::uint64_t bytes = 10'000, bool lossless = true) {
    wire::PairMessage said;
    auto& asked = *said.mutable_wish();
    WriteType(channel, type, *asked.mutable_wanted());
    asked.set_link(1);
    asked.set_lossless(lossless);
    asked.set_credit_messages(messages);
    asked.set_credit_bytes(bytes);
    Say(said);
    return ReadUntil(wire::PairMessage::kGranted);
  }
  /// The next message in order, without a payload.
  [[nodiscard]] Descriptor NextMessage() {
    Descriptor next{};
    next.link = wish.link();
    next.number = ++number_;
    next.slot = static_cast<std::uint32_t>(number_ % kSlots);
    next.publisher = id_.value;
    next.incarnation = 1;
    next.sequence = number_;
    return next;
  }
  void Write(const Descriptor& descriptor) {
    const std::uint64_t written = lane().written.load();
    lane().descriptors[written % kSlots] = descriptor;
    lane().written.store(written + 1);
    Ring();
  }
  void AddSegment(std::uint32_t number, std::shared_ptr<const Handle> handle) {
    wire::PairMessage said;
    said.mutable_segment_added()->set_segment(number);
    PairSocket::Handles handles;
    if (handle) handles.push_back(std::move(handle));
    Say(said, handles);
  }

  wire::Wish wish;                ///< For `lies`.
  std::uint64_t incarnation = 1;  ///< The incarnation that it claims.

 private:
  void Note(PairSocket::Frame& frame) {
    if (frame.message.wish().wanted().channel() == "lies") wish = frame.message.wish();
    if (!frame.message.has_hello() || frame.handles.size() != 3) return;
    std::string fault;
    their_bell_ = PeerBell::Open(frame.handles[0], frame.message.hello().bell_number(), fault);
  }

  const SessionId id_;
  Segment bell_;
  Segment lane_;
  Segment slip_;
  std::unique_ptr<PairSocket> socket_;
  std::unique_ptr<PeerBell> their_bell_;
  std::uint64_t number_ = 0;
  bool ended_ = false;
};

}  // namespace hgros::shm

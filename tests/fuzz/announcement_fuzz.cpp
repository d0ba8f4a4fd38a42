#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>

#include "discovery/beacon/datagram.hpp"
#include "discovery/registry/announcement_file.hpp"
#include "hgros/base/bytes.hpp"

namespace {

constexpr const char* kDomain = "robot";
constexpr const char* kSender = "192.0.2.7";

void Require(bool holds) {
  if (!holds) std::abort();
}

/// What was read must be the same after it is written and read again.
void CheckFile(hgros::Bytes bytes) {
  const hgros::discovery::ParsedFile parsed = hgros::discovery::ParseFile(bytes);
  Require(parsed.announcement.has_value() == parsed.fault.empty());
  if (!parsed.announcement) return;
  const std::string again = hgros::discovery::EncodeFile(*parsed.announcement);
  Require(hgros::discovery::ParseFile(hgros::AsBytes(again)).announcement == parsed.announcement);
}

/// Likewise, except for endpoints that only their own host can reach.
void CheckDatagram(hgros::Bytes bytes) {
  const auto heard = hgros::discovery::ParseDatagram(bytes, kDomain, kSender);
  if (!heard) return;
  Require(heard->peer.session.value != 0 && heard->peer.channels.empty());
  hgros::Announcement peer = heard->peer;
  peer.endpoints = {"tcp://*:1"};
  const std::string again = hgros::discovery::EncodeDatagram(peer, kDomain, heard->ends);
  peer.endpoints = {std::string("tcp://") + kSender + ":1"};
  const auto back = hgros::discovery::ParseDatagram(hgros::AsBytes(again), kDomain, kSender);
  Require(back && back->peer == peer && back->ends == heard->ends);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const hgros::Bytes bytes = std::as_bytes(std::span(data, size));
  CheckFile(bytes);
  CheckDatagram(bytes);
  return 0;
}

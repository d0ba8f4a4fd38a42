#pragma once

#include <cstdint>
#include <string>

#include "hgros/base/export.hpp"

namespace google::protobuf {
class Descriptor;
}

namespace hgros {

/// The parts of a message type that determine its meaning on the wire, as text: all reachable messages and enums by
/// full name, with their fields by number. Comments, files, options and the order of declarations are not included. The
/// grammar is in docs/wire-protocol.md ("Fingerprint of a protobuf type").
[[nodiscard]] HGROS_EXPORT std::string CanonicalSchema(const google::protobuf::Descriptor& type);

/// Fingerprint(CanonicalSchema(type)).
[[nodiscard]] HGROS_EXPORT std::uint64_t SchemaFingerprint(const google::protobuf::Descriptor& type);

/// A serialized google.protobuf.FileDescriptorSet: the type's file and all its imports, each once, dependencies first.
[[nodiscard]] HGROS_EXPORT std::string DescriptorSet(const google::protobuf::Descriptor& type);

/// As Descriptor::full_name(), for code that only has a forward declaration.
[[nodiscard]] HGROS_EXPORT const std::string& SchemaName(const google::protobuf::Descriptor& type);

}  // namespace hgros

#pragma once

#include <string>

#include "hgros/base/export.hpp"
#include "hgros/codec/raw_message.hpp"

namespace hgros {

/// Why messages of `theirs` cannot be read as `ours`, a type that the program names at run time; empty if they can. As
/// MisfitOf for a C++ type: call it once per publisher and channel.
/// Errors: throws Error if `ours` does not name a type, or if the process has named too many types at run time.
[[nodiscard]] HGROS_EXPORT std::string MisfitOf(const MessageSchema& theirs, const MessageSchema& ours);

/// `schema` with the fingerprint that sessions compare: for a protobuf type that of its descriptor set.
/// Errors: as MisfitOf.
[[nodiscard]] HGROS_EXPORT MessageSchema NamedSchema(const MessageSchema& schema);

}  // namespace hgros

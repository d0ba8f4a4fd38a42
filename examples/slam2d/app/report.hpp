#pragma once

#include <cstdint>
#include <optional>

#include <hgros/hgros.hpp>

#include "../nodes/writer_node.hpp"
#include "../relations_error.hpp"
#include "messages.hpp"

namespace slam2d {

/// The report on standard output at the end.
struct Report {
  std::optional<Written> written;  ///< Where the writer ran.
  std::optional<msg::Done> done;   ///< The writer's last message.
  std::optional<RelationsError> relations_error;
  std::optional<std::uint64_t> scans_sent;  ///< Where the source ran.
  hgros::GraphSnapshot graph;
};

/// For people.
void PrintText(const Report& report);
/// For programs: an object a line, with "kind": "result", "relations" or "node". Times in ns.
void PrintJson(const Report& report);

}  // namespace slam2d

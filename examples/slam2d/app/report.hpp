#pragma once

#include <cstdint>
#include <optional>

#include <hgros/hgros.hpp>

#include "../nodes/writer_node.hpp"
#include "../relations_error.hpp"
#include "messages.hpp"

namespace slam2d {

/// The final report on standard output.
struct Report {
  std::optional<Written> written;  ///< Set if the writer ran here.
  std::optional<msg::Done> done;   ///< The writer's last message.
  std::optional<RelationsError> relations_error;
  std::optional<std::uint64_t> scans_sent;  ///< Set if the source ran here.
  hgros::GraphSnapshot graph;
};

/// Prints it for people.
void PrintText(const Report& report);
/// Prints it for programs: one object per line, with "kind": "result", "relations" or "node". Times in ns.
void PrintJson(const Report& report);

}  // namespace slam2d

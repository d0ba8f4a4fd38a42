#pragma once

#include "check/file_finding.hpp"

namespace hgros::cli {

/// Removes findings between files that a comment ignores: `# hgros check: ignore CHANNEL, CHANNEL`, or all without
/// names. It is in one of their two lines, or in the line above.
void RemoveIgnored(FileFindings& findings);

}  // namespace hgros::cli

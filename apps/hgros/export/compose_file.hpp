#pragma once

#include "export/containers.hpp"

namespace hgros::cli {

/// A file for Docker Compose: a service for each process and program. They share a network namespace and a folder, so
/// that sessions share memory, and are apart from other robots of the host.
///
/// Errors: throws Error if a name cannot be that of a service.
[[nodiscard]] ExportedFile ComposeFile(const ExportedRobot& exported, const ContainerOptions& options);

}  // namespace hgros::cli

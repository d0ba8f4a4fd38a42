#pragma once

#include "export/containers.hpp"

namespace hgros::cli {

/// A Job of Kubernetes, or a Deployment if something is always started again. Its pod is the robot: a container for
/// each process and program. They share a network namespace and a folder, so that sessions share memory.
///
/// Errors: throws Error if two names are the same in Kubernetes.
[[nodiscard]] ExportedFile KubernetesManifest(const ExportedRobot& exported, const ContainerOptions& options);

}  // namespace hgros::cli

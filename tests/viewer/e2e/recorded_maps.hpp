#pragma once

#include <filesystem>
#include <memory>

#include "foxglove/Grid.pb.h"
#include "foxglove/VoxelGrid.pb.h"
#include "hgros/codec/bulk.hpp"

namespace hgros::viewer::test {

/// A map as map_server writes it: a P5 PGM, darker where it is more likely occupied, 205 for unknown.
[[nodiscard]] std::unique_ptr<Bulk<foxglove::Grid>> ReadMap(const std::filesystem::path& pgm, double cell_meters);

/// A binary octree as OctoMap writes it, with the occupied cells of its finest level.
[[nodiscard]] std::unique_ptr<Bulk<foxglove::VoxelGrid>> ReadOctree(const std::filesystem::path& bt);

}  // namespace hgros::viewer::test

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "hgros/base/bytes.hpp"

namespace hgros::viewer {

/// Reads the triangles of an STL file, text or binary, three corners each. Corners that are not numbers are an error.
/// The file's normals are ignored. Returns what is wrong, as a sentence, or nothing. After an error, `corners` is
/// unchanged.
[[nodiscard]] std::string ReadStl(Bytes file, std::vector<Eigen::Vector3f>& corners);

}  // namespace hgros::viewer

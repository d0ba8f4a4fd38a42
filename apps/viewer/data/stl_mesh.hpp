#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "hgros/base/bytes.hpp"

namespace hgros::viewer {

/// Reads the triangles of an STL file, text or binary: three corners each. Returns what is wrong, in a sentence, or
/// nothing; then `corners` is what it was before. Corners that are no numbers are an error; the file's normals are not
/// read.
[[nodiscard]] std::string ReadStl(Bytes file, std::vector<Eigen::Vector3f>& corners);

}  // namespace hgros::viewer

#pragma once

#include "viewer/data/points/point_batch.hpp"

namespace hgros::viewer {

/// Removes the points that are far from all others (BoxesAround): they are malformed.
void LeaveOutFar(PointBatch& batch);

}  // namespace hgros::viewer

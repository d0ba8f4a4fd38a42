#pragma once

#include "viewer/data/points/point_batch.hpp"

namespace hgros::viewer {

/// Removes the points that are far from all others (BoundsOfMost). A single one would take the precision of the others,
/// which are stored relative to the box around all.
void LeaveOutFar(PointBatch& batch);

}  // namespace hgros::viewer

#pragma once

#include "hgros/c/session.h"

// Transforms by the names of frames. hgros/hgros.h has the rules of all functions.

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/// The transforms of a session: those it sets, which other sessions get, and those it receives.
typedef struct hgros_transforms hgros_transforms;

/// p_target = rotation * p_source + translation. Never changes its layout.
typedef struct hgros_transform {
  double translation[3];  ///< x, y, z in meters.
  double rotation[4];     ///< A unit quaternion: x, y, z, w.
  int64_t stamp_ns;       ///< The time at which it holds; 0 if only static transforms connect the frames.
} hgros_transform;

/// A session has one at a time. Errors: HGROS_ERROR if it has one.
hgros_status hgros_transforms_open(hgros_session* session, hgros_transforms** transforms);
/// Sends what still waits. Errors: HGROS_WOULD_DEADLOCK inside a callback of the session; then nothing is closed.
hgros_status hgros_transforms_close(hgros_transforms* transforms);

/// Sets and sends the pose of `child` in `parent` at `pose->stamp_ns`. Errors: HGROS_REFUSED with the edge and the
/// reason, such as a second parent or a stamp too far ahead of the session's clock.
hgros_status hgros_transforms_set(hgros_transforms* transforms, const char* parent, const char* child,
                                  const hgros_transform* pose);
/// The same for a pose that does not move: the stamp is ignored, and sessions that join later get it, too.
hgros_status hgros_transforms_set_static(hgros_transforms* transforms, const char* parent, const char* child,
                                         const hgros_transform* pose);

/// T_target_source at the latest time that all edges between the frames have. The first lookup subscribes to the
/// transforms of other sessions, which takes a moment. Errors of these three: HGROS_UNKNOWN_FRAME, HGROS_NOT_CONNECTED,
/// HGROS_TOO_OLD, HGROS_TOO_NEW; the sentence has the frames, the edge and the times.
hgros_status hgros_transforms_lookup(hgros_transforms* transforms, const char* target, const char* source,
                                     hgros_transform* found);
/// The same at a time: positions between two stamps are interpolated linearly and rotations by slerp.
hgros_status hgros_transforms_lookup_at(hgros_transforms* transforms, const char* target, const char* source,
                                        int64_t time_ns, hgros_transform* found);
/// The same, but waits until it is there. Errors: HGROS_TIMED_OUT with the reason why it is not there; HGROS_TOO_OLD at
/// once; HGROS_CLOSED once hgros_session_end() is called.
hgros_status hgros_transforms_wait(hgros_transforms* transforms, const char* target, const char* source,
                                   int64_t time_ns, int64_t timeout_ns, hgros_transform* found);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

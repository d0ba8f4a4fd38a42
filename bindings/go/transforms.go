package hgros

// #include <stdlib.h>
// #include "bridge.h"
import "C"

import (
	"context"
	"fmt"
)

// Transform is p_target = rotation * p_source + translation.
type Transform struct {
	Translation [3]float64 // x, y, z in meters.
	Rotation    [4]float64 // A unit quaternion: x, y, z, w.
	Stamp       int64      // In ns: the time at which it holds; 0 if only static transforms connect the frames.
}

func (t *Transform) toC() (pose C.hgros_transform) {
	for i, value := range t.Translation {
		pose.translation[i] = C.double(value)
	}
	for i, value := range t.Rotation {
		pose.rotation[i] = C.double(value)
	}
	pose.stamp_ns = C.int64_t(t.Stamp)
	return pose
}

func transformFrom(pose *C.hgros_transform) (t Transform) {
	for i := range t.Translation {
		t.Translation[i] = float64(pose.translation[i])
	}
	for i := range t.Rotation {
		t.Rotation[i] = float64(pose.rotation[i])
	}
	t.Stamp = int64(pose.stamp_ns)
	return t
}

// Transforms are those of a session: what it sets, which other sessions get, and what it receives.
type Transforms struct {
	guard
	handle  *C.hgros_transforms
	session *Session
}

// Transforms opens the transforms of the session, which has one at a time.
func (s *Session) Transforms() (*Transforms, error) {
	transforms := &Transforms{session: s}
	if err := s.do("session", func() C.hgros_status {
		return C.hgros_transforms_open(s.handle, &transforms.handle)
	}); err != nil {
		return nil, err
	}
	return transforms, nil
}

// Close sends what still waits. Inside a callback of the session it does not wait: the rest is done once the callback
// has returned, and only then the session may open others.
func (t *Transforms) Close() error {
	return t.closeWith(func() C.hgros_status { return C.hgros_transforms_close(t.handle) })
}

func (t *Transforms) between(a, b string, call func(a, b *C.char) C.hgros_status) error {
	if err := uncut("The name of a frame", a, b); err != nil {
		return err
	}
	list, release := textList([]string{a, b})
	defer release()
	names := textsOf(list, 2)
	return t.do("transforms", func() C.hgros_status { return call(names[0], names[1]) })
}

// Set sets and sends the pose of a child frame in its parent at the pose's stamp.
func (t *Transforms) Set(parent, child string, pose Transform) error {
	chosen := pose.toC()
	return t.between(parent, child, func(parent, child *C.char) C.hgros_status {
		return C.hgros_transforms_set(t.handle, parent, child, &chosen)
	})
}

// SetStatic is the same for a pose that does not move: sessions that join later get it, too.
func (t *Transforms) SetStatic(parent, child string, pose Transform) error {
	chosen := pose.toC()
	return t.between(parent, child, func(parent, child *C.char) C.hgros_status {
		return C.hgros_transforms_set_static(t.handle, parent, child, &chosen)
	})
}

// Lookup is the transform from a source frame to a target at the latest time that all edges between them have.
func (t *Transforms) Lookup(target, source string) (Transform, error) {
	var found C.hgros_transform
	err := t.between(target, source, func(target, source *C.char) C.hgros_status {
		return C.hgros_transforms_lookup(t.handle, target, source, &found)
	})
	return transformFrom(&found), err
}

// LookupAt is the same at a time in ns.
func (t *Transforms) LookupAt(target, source string, time int64) (Transform, error) {
	var found C.hgros_transform
	err := t.between(target, source, func(target, source *C.char) C.hgros_status {
		return C.hgros_transforms_lookup_at(t.handle, target, source, C.int64_t(time), &found)
	})
	return transformFrom(&found), err
}

// Wait is the same, but waits until it is there. If the context ends first, the error says why it is not there.
func (t *Transforms) Wait(ctx context.Context, target, source string, time int64) (Transform, error) {
	var found C.hgros_transform
	var reason error
	err := poll(ctx, func(timeout C.int64_t) error {
		err := t.between(target, source, func(target, source *C.char) C.hgros_status {
			return C.hgros_transforms_wait(t.handle, target, source, C.int64_t(time), timeout, &found)
		})
		reason = err
		return err
	})
	if err != nil && err != reason && reason != nil {
		return Transform{}, fmt.Errorf("%w: %v", err, reason)
	}
	return transformFrom(&found), err
}

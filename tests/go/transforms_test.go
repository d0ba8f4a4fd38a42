package hgros_test

import (
	"context"
	"testing"
	"time"

	"hgros"
)

func TestTransformsAreFoundByName(t *testing.T) {
	robot, tool := open(t, nil), open(t, nil)
	sent := must(robot.Transforms())(t)
	seen := must(tool.Transforms())(t)
	upright := [4]float64{0, 0, 0, 1}
	require(t, sent.SetStatic("map", "base", hgros.Transform{Translation: [3]float64{1, 2, 3}, Rotation: upright}))
	found := must(seen.Wait(deadline(t), "map", "base", 0))(t)
	if found.Translation != [3]float64{1, 2, 3} || found.Rotation != upright {
		t.Fatalf("%+v", found)
	}
	now := time.Now().UnixNano()
	require(t, sent.Set("base", "arm", hgros.Transform{Translation: [3]float64{0, 0, 1}, Rotation: upright, Stamp: now}))
	found = must(sent.LookupAt("map", "arm", now))(t)
	if found.Translation != [3]float64{1, 2, 4} || found.Stamp != now {
		t.Fatalf("%+v", found)
	}
	fails(t, errorOf(sent.Lookup("map", "moon")), hgros.UnknownFrame, "")
	short, cancel := context.WithTimeout(context.Background(), 20*time.Millisecond)
	defer cancel()
	fails(t, errorOf(seen.Wait(short, "map", "moon", 0)), context.DeadlineExceeded, "moon")
	results := make(chan error, 1)
	go func() {
		_, err := seen.Wait(context.Background(), "map", "moon", 0)
		results <- err
	}()
	tool.End()
	expect(t, results, hgros.Closed)
	require(t, sent.Close())
}

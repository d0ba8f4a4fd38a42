package hgros_test

import (
	"context"
	"errors"
	"strings"
	"testing"
	"time"

	"hgros"
)

func TestTransformsAreFoundByName(t *testing.T) {
	robot, tool := open(t, nil), open(t, nil)
	sent, err := robot.Transforms()
	require(t, err)
	seen, err := tool.Transforms()
	require(t, err)
	upright := [4]float64{0, 0, 0, 1}
	require(t, sent.SetStatic("map", "base", hgros.Transform{Translation: [3]float64{1, 2, 3}, Rotation: upright}))
	found, err := seen.Wait(deadline(t), "map", "base", 0)
	require(t, err)
	if found.Translation != [3]float64{1, 2, 3} || found.Rotation != upright {
		t.Fatalf("%+v", found)
	}
	now := time.Now().UnixNano()
	require(t, sent.Set("base", "arm", hgros.Transform{Translation: [3]float64{0, 0, 1}, Rotation: upright, Stamp: now}))
	found, err = sent.LookupAt("map", "arm", now)
	require(t, err)
	if found.Translation != [3]float64{1, 2, 4} || found.Stamp != now {
		t.Fatalf("%+v", found)
	}
	if _, err := sent.Lookup("map", "moon"); !errors.Is(err, hgros.UnknownFrame) {
		t.Fatal("an unknown frame gave", err)
	}
	short, cancel := context.WithTimeout(context.Background(), 20*time.Millisecond)
	defer cancel()
	if _, err := seen.Wait(short, "map", "moon", 0); !errors.Is(err, context.DeadlineExceeded) ||
		!strings.Contains(err.Error(), "moon") {
		t.Fatal("waiting for an unknown frame gave", err)
	}
	results := make(chan error, 1)
	go func() {
		_, err := seen.Wait(context.Background(), "map", "moon", 0)
		results <- err
	}()
	tool.End()
	expect(t, results, hgros.Closed)
	require(t, sent.Close())
}

package hgros_test

import (
	"context"
	"errors"
	"fmt"
	"os"
	"path/filepath"
	"strings"
	"testing"
	"time"

	"hgros"

	"google.golang.org/protobuf/types/known/wrapperspb"
)

func TestLoanIsFilledInPlaceAndPublishedOnce(t *testing.T) {
	session := open(t, nil)
	schema := must(hgros.RawSchema("my.bytes", hgros.Custom, 0))(t)
	queue := must(session.SubscribeRaw("bytes", &hgros.SubscribeOptions{KeepAll: 1}))(t)
	publisher := must(session.AdvertiseRaw("bytes", schema, nil))(t)
	lend := func(text string) *hgros.Loan {
		loan := must(publisher.Loan(len(text)))(t)
		if copy(loan.Data(), text) != len(text) {
			t.Fatal("the loan is too small for", text)
		}
		return loan
	}
	first, second := lend("first"), lend("second")
	require(t, first.Publish())
	if err := first.Publish(); !errors.Is(err, hgros.Closed) || first.Data() != nil {
		t.Fatal("publishing a loan again gave", err)
	}
	if err := second.Publish(); !errors.Is(err, hgros.Full) || string(second.Data()) != "second" {
		t.Fatal("a loan for which there is no room gave", err)
	}
	short, cancel := context.WithTimeout(context.Background(), 20*time.Millisecond)
	defer cancel()
	fails(t, second.PublishWait(short), context.DeadlineExceeded, "")
	for _, wanted := range []string{"first", "second"} {
		message := must(queue.Take(deadline(t)))(t)
		if string(message.Data()) != wanted {
			t.Fatalf("%q instead of %q", message.Data(), wanted)
		}
		message.Close()
		if wanted == "first" {
			require(t, second.PublishWait(deadline(t)))
		}
	}
	lend("unused").Close()
	empty := must(publisher.Loan(0))(t)
	require(t, empty.Publish())
	fails(t, errorOf(publisher.Loan(-1)), hgros.InvalidArgument, "")
}

func TestTimerFollowsTheClockUntilItIsClosedInItsOwnCallback(t *testing.T) {
	session := open(t, nil)
	begun := session.Now()
	if ago := time.Since(begun); ago < 0 || ago > patience {
		t.Fatal("the session's clock is off by", ago)
	}
	ticks := make(chan hgros.Tick, 10)
	made := make(chan *hgros.Timer, 1)
	timer := must(session.NewTimer("metronome", 10*time.Millisecond, func(tick hgros.Tick) {
		ticks <- tick
		if len(ticks) == 3 {
			(<-made).Close()
		}
	}, &hgros.TimerOptions{First: time.Millisecond, CatchUp: true}))(t)
	made <- timer
	waitUntil(t, "three turns", func() bool { return len(ticks) == 3 })
	first, second := <-ticks, <-ticks
	if second.Planned.Sub(first.Planned) != 10*time.Millisecond || first.Now.Before(first.Planned) {
		t.Fatalf("%+v, then %+v", first, second)
	}
	fails(t, errorOf(session.NewTimer("bad", 0, func(hgros.Tick) {}, nil)), hgros.Failed, "")
	due := session.Now().Add(5 * time.Millisecond)
	require(t, session.SleepUntil(due))
	if session.Now().Before(due) {
		t.Fatal("it woke too early")
	}
	results := make(chan error, 1)
	go func() { results <- session.SleepUntil(session.Now().Add(time.Hour)) }()
	session.End()
	expect(t, results, hgros.Closed)
}

func TestCloseInsideACallbackEndsTheSession(t *testing.T) {
	lines := make(chan string, 1000)
	here, there := open(t, &hgros.SessionOptions{Log: func(_ hgros.Level, line string) { lines <- line }}), open(t, nil)
	must(hgros.Subscribe[text](here, "words", nil))(t)
	must(hgros.Advertise[text](there, "words", nil))(t)
	require(t, there.WaitForSubscribers(deadline(t), "words", 1))
	closed := make(chan struct{}, 1000)
	must(here.NewTimer("closer", time.Millisecond, func(hgros.Tick) {
		here.Close()
		closed <- struct{}{}
	}, nil))(t)
	<-closed
	waitUntil(t, "the other session is told", func() bool {
		peers, err := there.Peers()
		return err == nil && len(peers) == 0
	})
	here.Close() // Waits for the other one.
	endsOutsideOfCallbacks(t, lines)
}

func endsOutsideOfCallbacks(t *testing.T, lines chan string) {
	t.Helper()
	for len(lines) > 0 {
		if line := <-lines; strings.Contains(line, "destroyed inside") {
			t.Fatal(line)
		}
	}
}

func TestLastUseInACallbackDoesNotEndTheSession(t *testing.T) {
	lines, logging, goOn := make(chan string, 1000), make(chan struct{}), make(chan struct{})
	session := open(t, &hgros.SessionOptions{Log: func(_ hgros.Level, line string) {
		if strings.Contains(line, "in use") {
			close(logging)
			<-goOn
		}
		lines <- line
	}})
	must(session.NewTimer("user", time.Hour, func(hgros.Tick) {
		_ = session.Log(hgros.LogInfo, "The session is in use.")
	}, &hgros.TimerOptions{First: time.Millisecond}))(t)
	<-logging
	closed := make(chan struct{})
	go func() {
		session.Close()
		close(closed)
	}()
	waitUntil(t, "the session is closed", func() bool { return session.ID() == 0 })
	close(goOn)
	<-closed
	endsOutsideOfCallbacks(t, lines)
}

func TestSimulatedClockMovesTimersOfOtherSessions(t *testing.T) {
	os.Setenv("HGROS_DOMAIN", fmt.Sprintf("go-%d-clock", os.Getpid()))
	sessions := make([]*hgros.Session, 2)
	for i := range sessions {
		session := must(hgros.Open("time: simulated", nil))(t)
		t.Cleanup(session.Close)
		sessions[i] = session
	}
	start := time.Unix(1000, 0)
	clock := must(sessions[0].NewSimulatedClock(start, true))(t)
	follows := func(wanted time.Time) {
		t.Helper()
		waitUntil(t, "both sessions follow", func() bool {
			return sessions[0].Now().Equal(wanted) && sessions[1].Now().Equal(wanted)
		})
	}
	follows(start)
	ticks := make(chan hgros.Tick, 10)
	must(sessions[1].NewTimer("seconds", time.Second, func(tick hgros.Tick) { ticks <- tick }, nil))(t)
	require(t, clock.Step(2500*time.Millisecond))
	follows(start.Add(2500 * time.Millisecond))
	if tick := <-ticks; tick.Planned.Sub(start)%time.Second != 0 {
		t.Fatalf("%+v", tick)
	}
	require(t, clock.Jump(start.Add(time.Hour)))
	follows(start.Add(time.Hour))
	require(t, clock.SetRate(1000))
	require(t, clock.Resume())
	waitUntil(t, "time passes", func() bool { return sessions[1].Now().After(start.Add(time.Hour + time.Second)) })
	require(t, clock.Pause())
	require(t, clock.Jump(start))
	follows(start)
	for _, refused := range []error{clock.Step(-1), clock.SetRate(0)} {
		if !errors.Is(refused, hgros.Failed) {
			t.Fatal("a number out of range gave", refused)
		}
	}
	require(t, clock.Close())
	if err := clock.Step(1); !errors.Is(err, hgros.Closed) || !clock.Now().IsZero() {
		t.Fatal("a closed clock gave", err)
	}
}

func TestPartsAreClosedInsideACallback(t *testing.T) {
	session := open(t, nil)
	params := must(session.Params())(t)
	require(t, params.Declare("speed", 1, nil))
	transforms := must(session.Transforms())(t)
	clock := must(session.NewSimulatedClock(time.Unix(1000, 0), true))(t)
	results := make(chan error, 10)
	made := make(chan *hgros.Timer, 1)
	timer := must(session.NewTimer("closer", time.Millisecond, func(hgros.Tick) {
		results <- params.Close()
		results <- transforms.Close()
		results <- clock.Close()
		(<-made).Close()
	}, nil))(t)
	made <- timer
	for i := 0; i < 3; i++ {
		require(t, <-results)
	}
	fails(t, errorOf(params.Integer("speed")), hgros.Closed, "")
	waitUntil(t, "new ones can be opened", func() bool {
		again, err := session.Transforms()
		if err == nil {
			require(t, again.Close())
		}
		return err == nil
	})
	own := must(session.Params())(t)
	require(t, own.Declare("speed", 1, nil))
	watch := must(own.OnChange("speed", func(string, string) { results <- own.Close() }))(t)
	defer watch.Close()
	require(t, own.Set("speed", 2))
	require(t, <-results)
	fails(t, own.Set("speed", 3), hgros.Closed, "")
}

func TestSnapshotAndUsersOfAChannelAreSeen(t *testing.T) {
	session := open(t, &hgros.SessionOptions{Name: "watched"})
	must(hgros.Subscribe[text](session, "words", &hgros.SubscribeOptions{KeepAll: 1}))(t)
	channels := must(session.Channels())(t)
	found := false
	for _, channel := range channels {
		if channel.Name == "words" && len(channel.SubscribedBy) == 1 && len(channel.PublishedBy) == 0 {
			user := channel.SubscribedBy[0]
			found = user.Session == session.ID() && user.Lossless && user.TypeName == "google.protobuf.StringValue"
		}
	}
	if !found {
		t.Fatalf("the subscriber is not in %+v", channels)
	}
	snapshot := must(session.Snapshot())(t)
	defer snapshot.Close()
	decoded := must(snapshot.Decode())(t)
	if name := decoded.ProtoReflect().Descriptor().FullName(); name != "hgros.Snapshot" {
		t.Fatal("the snapshot is a", name)
	}
	if !strings.Contains(string(snapshot.Data()), "words") {
		t.Fatal("the snapshot does not have the channel")
	}
}

func TestTextsThatCWouldCutAreRefused(t *testing.T) {
	session := open(t, nil)
	params := must(session.Params())(t)
	transforms := must(session.Transforms())(t)
	schema := must(hgros.KnownSchema("foxglove.Log"))(t)
	const cut = "words\x00more"
	for i, err := range []error{
		errorOf(hgros.Open("{}\x00", nil)),
		errorOf(hgros.Open("", &hgros.SessionOptions{Name: cut})),
		errorOf(hgros.OpenFiles([]string{cut}, nil)),
		session.Log(hgros.LogInfo, cut),
		errorOf(session.AdvertiseRaw(cut, schema, nil)),
		errorOf(session.SubscribeRaw(cut, nil)),
		errorOf(session.SubscribeRaw("words", &hgros.SubscribeOptions{Name: cut})),
		session.WaitForSubscribers(deadline(t), cut, 1),
		session.WaitForPublishers(deadline(t), cut, 1),
		errorOf(hgros.Serve(session, cut, func(request text) (text, error) { return request, nil }, nil)),
		errorOf(hgros.Call[text, text](deadline(t), session, cut, wrapperspb.String(""))),
		errorOf(session.NewTimer(cut, time.Second, func(hgros.Tick) {}, nil)),
		errorOf(session.ParamsOf(cut, patience)),
		errorOf(session.Params(cut)),
		errorOf(hgros.KnownSchema(cut)),
		errorOf(hgros.RawSchema(cut, hgros.Custom, 0)),
		params.Declare(cut, 1, nil),
		params.Declare("a", cut, nil),
		params.Declare("a", "b", &hgros.ParamInfo{Unit: cut}),
		params.Declare("a", "b", &hgros.ParamInfo{Choices: []string{"b", cut}}),
		params.Set(cut, 1),
		params.Set("a", cut),
		params.SetYAML("a", cut),
		params.Remove(cut),
		errorOf(params.Text(cut)),
		errorOf(params.OnChange(cut, func(string, string) {})),
		transforms.SetStatic("map", cut, hgros.Transform{}),
		errorOf(transforms.Lookup("map", cut)),
	} {
		if !errors.Is(err, hgros.InvalidArgument) || !strings.Contains(err.Error(), "U+0000") {
			t.Errorf("use %d gave %v", i, err)
		}
	}
}

func TestParametersAreDeclaredSetAndWatched(t *testing.T) {
	session := open(t, nil)
	file := filepath.Join(t.TempDir(), "params.yaml")
	require(t, os.WriteFile(file, []byte("wheel: {radius: 0.25}\n"), 0o600))
	params := must(session.Params(file))(t)
	most := 1.0
	require(t, params.Declare("wheel.radius", 0.1, &hgros.ParamInfo{Unit: "m", Most: &most}))
	require(t, params.Declare("wheel.count", 4, nil))
	require(t, params.Declare("name", "it's: \"mine\"", nil))
	require(t, params.Declare("gains", []float64{1, 2.5}, nil))
	require(t, params.Declare("on", true, nil))
	radius := must(params.Number("wheel.radius"))(t)
	count := must(params.Integer("wheel.count"))(t)
	name := must(params.Text("name"))(t)
	on := must(params.Bool("on"))(t)
	gains := must(params.YAML("gains"))(t)
	if radius != 0.25 || count != 4 || name != "it's: \"mine\"" || !on || gains != "[1.0, 2.5]" {
		t.Fatal(radius, count, name, on, gains)
	}
	changes := make(chan string, 10)
	watch := must(params.OnChange("wheel", func(path, yaml string) { changes <- path + "=" + yaml }))(t)
	require(t, params.Set("wheel.radius", 0.5))
	if change := <-changes; change != "wheel.radius=0.5" {
		t.Fatal(change)
	}
	fails(t, params.Set("wheel.radius", 2.0), hgros.Refused, "1")
	fails(t, params.Set("wheel.radius", struct{}{}), hgros.InvalidArgument, "")
	inItself := map[string]any{}
	inItself["again"] = inItself
	fails(t, params.Declare("map", inItself, nil), hgros.InvalidArgument, "")
	watch.Close()
	require(t, params.Set("wheel.count", 3))
	if len(changes) != 0 {
		t.Fatal("a closed watch told of", <-changes)
	}
	require(t, params.Close())
	fails(t, errorOf(params.Bool("on")), hgros.Closed, "")
}

func TestParametersOfAnotherSession(t *testing.T) {
	robot, tool := open(t, &hgros.SessionOptions{Name: "robot"}), open(t, nil)
	own := must(robot.Params())(t)
	require(t, own.Declare("speed", 1, nil))
	theirs := must(tool.ParamsOf("robot", patience))(t)
	waitUntil(t, "the parameter can be set", func() bool { return theirs.Set("speed", 7) == nil })
	speed := must(own.Integer("speed"))(t)
	if speed != 7 {
		t.Fatal(speed)
	}
	require(t, theirs.Close())
}

func TestPeersAndChannelsAreSeen(t *testing.T) {
	here := open(t, nil)
	came := make(chan hgros.Peer, 10)
	must(here.OnPeer(func(event hgros.PeerEvent, peer hgros.Peer, channel, reason string) {
		if event == hgros.PeerCame {
			came <- peer
		}
	}))(t)
	must(hgros.Subscribe[text](here, "words", nil))(t)
	there := open(t, nil)
	must(hgros.Advertise[text](there, "words", nil))(t)
	require(t, there.WaitForSubscribers(deadline(t), "words", 1))
	select {
	case peer := <-came:
		if peer.ID != there.ID() || peer.PID != int64(os.Getpid()) {
			t.Fatalf("%+v", peer)
		}
	case <-deadline(t).Done():
		t.Fatal("no session came")
	}
	peers := must(here.Peers())(t)
	if len(peers) != 1 || peers[0].ID != there.ID() {
		t.Fatalf("%+v", peers)
	}
	waitUntil(t, "the channel is known", func() bool {
		channels := must(here.Channels())(t)
		for _, channel := range channels {
			if channel.Name == "words" && channel.TypeName == "google.protobuf.StringValue" && channel.Publishers == 1 {
				return true
			}
		}
		return false
	})
}

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

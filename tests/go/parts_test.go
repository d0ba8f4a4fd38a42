package hgros_test

import (
	"context"
	"errors"
	"fmt"
	"os"
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

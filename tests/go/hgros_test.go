package hgros_test

import (
	"context"
	"errors"
	"fmt"
	"os"
	"runtime"
	"strings"
	"sync"
	"testing"
	"time"

	"hgros"

	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/types/known/structpb"
	"google.golang.org/protobuf/types/known/wrapperspb"
)

type text = *wrapperspb.StringValue

const patience = 45 * time.Second

func open(t *testing.T, options *hgros.SessionOptions) *hgros.Session {
	t.Helper()
	os.Setenv("HGROS_DOMAIN", fmt.Sprintf("go-%d-%s", os.Getpid(), strings.ToLower(t.Name())))
	session, err := hgros.Open("", options)
	require(t, err)
	t.Cleanup(session.Close)
	return session
}

func deadline(t *testing.T) context.Context {
	ctx, cancel := context.WithTimeout(context.Background(), patience)
	t.Cleanup(cancel)
	return ctx
}

func require(t *testing.T, err error) {
	t.Helper()
	if err != nil {
		t.Fatal(err)
	}
}

func waitUntil(t *testing.T, what string, holds func() bool) {
	t.Helper()
	for end := time.Now().Add(patience); !holds(); time.Sleep(2 * time.Millisecond) {
		if time.Now().After(end) {
			t.Fatal(what, "did not hold in time")
		}
	}
}

func TestTypedMessagesGoFromSessionToSession(t *testing.T) {
	from, to := open(t, nil), open(t, nil)
	queue, err := hgros.Subscribe[text](to, "words", &hgros.SubscribeOptions{KeepAll: 10})
	require(t, err)
	publisher, err := hgros.Advertise[text](from, "words", nil)
	require(t, err)
	require(t, from.WaitForSubscribers(deadline(t), "words", 1))
	for i := 0; i < 50; i++ {
		require(t, publisher.PublishWait(deadline(t), wrapperspb.String(fmt.Sprint(i))))
		got, err := queue.Next(deadline(t))
		require(t, err)
		if got.Value != fmt.Sprint(i) {
			t.Fatalf("got %q instead of %d", got.Value, i)
		}
	}
	require(t, publisher.Publish(wrapperspb.String("last")))
	message, err := queue.Take(deadline(t))
	require(t, err)
	defer message.Close()
	info, err := message.Info()
	require(t, err)
	if !info.Remote || info.Publisher != from.ID() || info.PublishTime.Year() < 2000 {
		t.Fatalf("%+v is not what session %d sent", info, from.ID())
	}
}

func TestTheTypeComesWithTheChannel(t *testing.T) {
	from, to := open(t, nil), open(t, nil)
	publisher, err := hgros.Advertise[*structpb.Struct](from, "things", &hgros.PublishOptions{Latched: 1})
	require(t, err)
	value, err := structpb.NewStruct(map[string]interface{}{"wheels": 4, "names": []interface{}{"a", "b"}})
	require(t, err)
	require(t, publisher.Publish(value))
	queue, err := to.SubscribeRaw("things", nil)
	require(t, err)
	message, err := queue.Take(deadline(t)) // The latched one.
	require(t, err)
	defer message.Close()
	decoded, err := message.Decode()
	require(t, err)
	data, err := proto.Marshal(decoded)
	require(t, err)
	again := &structpb.Struct{}
	require(t, proto.Unmarshal(data, again))
	if !proto.Equal(again, value) {
		t.Fatalf("%v instead of %v", again, value)
	}
	if err := message.Read(&wrapperspb.StringValue{}); !errors.Is(err, hgros.TypeMismatch) ||
		!strings.Contains(err.Error(), "google.protobuf.Struct") {
		t.Fatal("reading as another type gave", err)
	}
}

func TestSchemasOfDescriptorsAreThoseOfTheLibrary(t *testing.T) {
	known, err := hgros.KnownSchema("foxglove.Log")
	require(t, err)
	descriptor, err := known.Descriptor()
	require(t, err)
	made, err := hgros.SchemaOf(descriptor)
	require(t, err)
	if made.TypeName() != "foxglove.Log" || made.Encoding() != hgros.Protobuf || made.Fingerprint() == 0 ||
		made.Fingerprint() != known.Fingerprint() {
		t.Fatalf("%s with %x instead of %x", made.TypeName(), made.Fingerprint(), known.Fingerprint())
	}
	if _, err := hgros.KnownSchema("no.Such"); !errors.Is(err, hgros.NotFound) {
		t.Fatal("an unknown type gave", err)
	}
}

func TestRawBytesAndLeases(t *testing.T) {
	session := open(t, nil)
	schema, err := hgros.RawSchema("my.bytes", hgros.Custom, 0)
	require(t, err)
	queue, err := session.SubscribeRaw("bytes", nil)
	require(t, err)
	publisher, err := session.AdvertiseRaw("bytes", schema, nil)
	require(t, err)
	before := hgros.Leases()
	require(t, publisher.Publish([]byte("abc")))
	require(t, publisher.Publish(nil))
	first, err := queue.Take(deadline(t))
	require(t, err)
	second, err := queue.Take(deadline(t))
	require(t, err)
	if string(first.Data()) != "abc" || len(second.Data()) != 0 || hgros.Leases() != before+2 {
		t.Fatalf("%q, %q, %d leases", first.Data(), second.Data(), hgros.Leases()-before)
	}
	if _, err := first.Decode(); !errors.Is(err, hgros.NotFound) {
		t.Fatal("decoding bytes of my own gave", err)
	}
	first.Close()
	first.Close()
	if first.Data() != nil || hgros.Leases() != before+1 {
		t.Fatal("a closed message still has its lease")
	}
	second = nil
	waitUntil(t, "a forgotten message gives its lease back", func() bool {
		runtime.GC()
		return hgros.Leases() == before
	})
}

func TestQueuesDropOrHoldBack(t *testing.T) {
	session := open(t, nil)
	newest, err := hgros.Subscribe[text](session, "newest", &hgros.SubscribeOptions{KeepLast: 2})
	require(t, err)
	every, err := hgros.Subscribe[text](session, "every", &hgros.SubscribeOptions{KeepAll: 2})
	require(t, err)
	dropping, err := hgros.Advertise[text](session, "newest", nil)
	require(t, err)
	lossless, err := hgros.Advertise[text](session, "every", nil)
	require(t, err)
	for i := 0; i < 5; i++ {
		require(t, dropping.Publish(wrapperspb.String(fmt.Sprint(i))))
	}
	stats, err := newest.Stats()
	require(t, err)
	if stats.Dropped != 3 || stats.Queued != 2 || stats.Received != 5 {
		t.Fatalf("%+v", stats)
	}
	got, err := newest.Next(deadline(t))
	require(t, err)
	if got.Value != "3" {
		t.Fatalf("the oldest that is kept is %q", got.Value)
	}
	require(t, lossless.Publish(wrapperspb.String("1")))
	require(t, lossless.Publish(wrapperspb.String("2")))
	if err := lossless.Publish(wrapperspb.String("3")); !errors.Is(err, hgros.Full) {
		t.Fatal("a full lossless queue gave", err)
	}
	short, cancel := context.WithTimeout(context.Background(), 20*time.Millisecond)
	defer cancel()
	if err := lossless.PublishWait(short, wrapperspb.String("3")); !errors.Is(err, context.DeadlineExceeded) {
		t.Fatal("waiting for room gave", err)
	}
	_, err = every.Next(deadline(t))
	require(t, err)
	require(t, lossless.PublishWait(deadline(t), wrapperspb.String("3")))
}

func TestWhatWaitsIsWoken(t *testing.T) {
	session := open(t, nil)
	ended, err := session.SubscribeRaw("a", nil)
	require(t, err)
	closed, err := session.SubscribeRaw("b", nil)
	require(t, err)
	ctx, cancel := context.WithCancel(context.Background())
	results := make(chan error, 4)
	var waiting sync.WaitGroup
	wait := func(queue *hgros.RawSubscription, ctx context.Context) {
		waiting.Add(1)
		go func() {
			waiting.Done()
			_, err := queue.Take(ctx)
			results <- err
		}()
	}
	wait(ended, ctx)
	waiting.Wait()
	cancel()
	expect(t, results, context.Canceled)
	wait(closed, context.Background())
	waiting.Wait()
	closed.Close()
	expect(t, results, hgros.Closed)
	wait(ended, context.Background())
	wait(ended, deadline(t))
	waiting.Wait()
	session.End()
	expect(t, results, hgros.Closed)
	expect(t, results, hgros.Closed)
	session.Close()
	session.Close()
	if _, err := session.SubscribeRaw("c", nil); !errors.Is(err, hgros.Closed) {
		t.Fatal("a closed session gave", err)
	}
}

func expect(t *testing.T, results chan error, wanted error) {
	t.Helper()
	select {
	case err := <-results:
		if !errors.Is(err, wanted) {
			t.Fatalf("%v instead of %v", err, wanted)
		}
	case <-time.After(patience):
		t.Fatal("nothing woke what waits for", wanted)
	}
}

func TestServicesReplyFailAndPanic(t *testing.T) {
	server, client := open(t, nil), open(t, nil)
	entered, goOn := make(chan struct{}, 1), make(chan struct{})
	_, err := hgros.Serve(server, "shout", func(word text) (text, error) {
		switch word.Value {
		case "fail":
			return nil, errors.New("I have no voice")
		case "panic":
			panic("a mouse")
		case "wait":
			entered <- struct{}{}
			<-goOn
		}
		return wrapperspb.String(strings.ToUpper(word.Value)), nil
	}, nil)
	require(t, err)
	call := func(ctx context.Context, word string) (string, error) {
		reply, err := hgros.Call[text, text](ctx, client, "shout", wrapperspb.String(word))
		return reply.GetValue(), err
	}
	waitUntil(t, "the service is known", func() bool {
		_, err := call(deadline(t), "hello")
		return !errors.Is(err, hgros.NoServer)
	})
	if reply, err := call(deadline(t), "hello"); err != nil || reply != "HELLO" {
		t.Fatal(reply, err)
	}
	if _, err := call(deadline(t), "fail"); !errors.Is(err, hgros.HandlerFailed) ||
		!strings.Contains(err.Error(), "I have no voice") {
		t.Fatal("a handler that fails gave", err)
	}
	if _, err := call(deadline(t), "panic"); !errors.Is(err, hgros.HandlerFailed) ||
		!strings.Contains(err.Error(), "a mouse") {
		t.Fatal("a handler that panics gave", err)
	}
	ctx, cancel := context.WithCancel(deadline(t))
	results := make(chan error, 1)
	go func() {
		_, err := call(ctx, "wait")
		results <- err
	}()
	<-entered
	cancel()
	expect(t, results, context.Canceled)
	close(goOn)
	if _, err := hgros.Call[text, text](deadline(t), client, "nobody", wrapperspb.String("")); !errors.Is(err,
		hgros.NoServer) {
		t.Fatal("a service that nobody offers gave", err)
	}
}

func TestErrorsAndTheLog(t *testing.T) {
	var failed *hgros.Error
	if _, err := hgros.Open("sesion: {}", nil); !errors.As(err, &failed) || failed.Code != hgros.ConfigError ||
		failed.Sentence == "" {
		t.Fatal("a wrong configuration gave", err)
	}
	if _, err := hgros.OpenFiles([]string{"/no/such.yaml"}, nil); !errors.Is(err, hgros.ConfigError) ||
		!strings.Contains(err.Error(), "/no/such.yaml") {
		t.Fatal("a file that is not there gave", err)
	}
	lines := make(chan string, 1000)
	session := open(t, &hgros.SessionOptions{Name: "logger", Log: func(level hgros.Level, line string) {
		lines <- fmt.Sprint(level, " ", line)
	}})
	require(t, session.Log(hgros.LogWarning, "It rains."))
	for timeout := time.After(patience); ; {
		select {
		case line := <-lines:
			if line == fmt.Sprint(hgros.LogWarning, " It rains.") {
				return
			}
		case <-timeout:
			t.Fatal("the line did not reach the log")
		}
	}
}

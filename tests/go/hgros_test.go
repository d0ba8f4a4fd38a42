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
	session := must(hgros.Open("", options))(t)
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

// must is the value of a call that has to succeed: must(call())(t).
func must[T any](value T, err error) func(*testing.T) T {
	return func(t *testing.T) T {
		t.Helper()
		require(t, err)
		return value
	}
}

func errorOf(_ any, err error) error { return err }

// fails checks the kind of an error and a part of its sentence.
func fails(t *testing.T, err, kind error, part string) {
	t.Helper()
	if !errors.Is(err, kind) || !strings.Contains(err.Error(), part) {
		t.Fatalf("%v instead of %v with %q", err, kind, part)
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
	queue := must(hgros.Subscribe[text](to, "words", &hgros.SubscribeOptions{KeepAll: 10}))(t)
	publisher := must(hgros.Advertise[text](from, "words", nil))(t)
	require(t, from.WaitForSubscribers(deadline(t), "words", 1))
	require(t, publisher.Publish(wrapperspb.String("last")))
	message := must(queue.Take(deadline(t)))(t)
	defer message.Close()
	info := must(message.Info())(t)
	if !info.Remote || info.Publisher != from.ID() || info.PublishTime.Year() < 2000 {
		t.Fatalf("%+v is not what session %d sent", info, from.ID())
	}
}

func TestTheTypeComesWithTheChannel(t *testing.T) {
	from, to := open(t, nil), open(t, nil)
	publisher := must(hgros.Advertise[*structpb.Struct](from, "things", &hgros.PublishOptions{Latched: 1}))(t)
	value := must(structpb.NewStruct(map[string]interface{}{"wheels": 4, "names": []interface{}{"a", "b"}}))(t)
	require(t, publisher.Publish(value))
	queue := must(to.SubscribeRaw("things", nil))(t)
	message := must(queue.Take(deadline(t)))(t) // The latched one.
	defer message.Close()
	decoded := must(message.Decode())(t)
	data := must(proto.Marshal(decoded))(t)
	again := &structpb.Struct{}
	require(t, proto.Unmarshal(data, again))
	if !proto.Equal(again, value) {
		t.Fatalf("%v instead of %v", again, value)
	}
	fails(t, message.Read(&wrapperspb.StringValue{}), hgros.TypeMismatch, "google.protobuf.Struct")
}

func TestSchemasOfDescriptorsAreThoseOfTheLibrary(t *testing.T) {
	known := must(hgros.KnownSchema("foxglove.Log"))(t)
	descriptor := must(known.Descriptor())(t)
	made := must(hgros.SchemaOf(descriptor))(t)
	if made.TypeName() != "foxglove.Log" || made.Encoding() != hgros.Protobuf || made.Fingerprint() == 0 ||
		made.Fingerprint() != known.Fingerprint() {
		t.Fatalf("%s with %x instead of %x", made.TypeName(), made.Fingerprint(), known.Fingerprint())
	}
	fails(t, errorOf(hgros.KnownSchema("no.Such")), hgros.NotFound, "")
}

func TestRawBytesAndLeases(t *testing.T) {
	session := open(t, nil)
	schema := must(hgros.RawSchema("my.bytes", hgros.Custom, 0))(t)
	queue := must(session.SubscribeRaw("bytes", nil))(t)
	publisher := must(session.AdvertiseRaw("bytes", schema, nil))(t)
	before := hgros.Leases()
	require(t, publisher.Publish([]byte("abc")))
	require(t, publisher.Publish(nil))
	first := must(queue.Take(deadline(t)))(t)
	second := must(queue.Take(deadline(t)))(t)
	if string(first.Data()) != "abc" || len(second.Data()) != 0 || hgros.Leases() != before+2 {
		t.Fatalf("%q, %q, %d leases", first.Data(), second.Data(), hgros.Leases()-before)
	}
	fails(t, errorOf(first.Decode()), hgros.NotFound, "")
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
	newest := must(hgros.Subscribe[text](session, "newest", &hgros.SubscribeOptions{KeepLast: 2}))(t)
	every := must(hgros.Subscribe[text](session, "every", &hgros.SubscribeOptions{KeepAll: 2}))(t)
	dropping := must(hgros.Advertise[text](session, "newest", nil))(t)
	lossless := must(hgros.Advertise[text](session, "every", nil))(t)
	for i := 0; i < 5; i++ {
		require(t, dropping.Publish(wrapperspb.String(fmt.Sprint(i))))
	}
	stats := must(newest.Stats())(t)
	if stats.Dropped != 3 || stats.Queued != 2 || stats.Received != 5 {
		t.Fatalf("%+v", stats)
	}
	got := must(newest.Next(deadline(t)))(t)
	if got.Value != "3" {
		t.Fatalf("the oldest that is kept is %q", got.Value)
	}
	require(t, lossless.Publish(wrapperspb.String("1")))
	require(t, lossless.Publish(wrapperspb.String("2")))
	fails(t, lossless.Publish(wrapperspb.String("3")), hgros.Full, "")
	short, cancel := context.WithTimeout(context.Background(), 20*time.Millisecond)
	defer cancel()
	fails(t, lossless.PublishWait(short, wrapperspb.String("3")), context.DeadlineExceeded, "")
	must(every.Next(deadline(t)))(t)
	require(t, lossless.PublishWait(deadline(t), wrapperspb.String("3")))
}

func TestWhatWaitsIsWoken(t *testing.T) {
	session := open(t, nil)
	ended := must(session.SubscribeRaw("a", nil))(t)
	closed := must(session.SubscribeRaw("b", nil))(t)
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
	fails(t, errorOf(session.SubscribeRaw("c", nil)), hgros.Closed, "")
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
	must(hgros.Serve(server, "shout", func(word text) (text, error) {
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
	}, nil))(t)
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
	fails(t, errorOf(call(deadline(t), "fail")), hgros.HandlerFailed, "I have no voice")
	fails(t, errorOf(call(deadline(t), "panic")), hgros.HandlerFailed, "a mouse")
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
	fails(t, errorOf(hgros.Call[text, text](deadline(t), client, "nobody", wrapperspb.String(""))), hgros.NoServer, "")
}

func TestErrorsAndTheLog(t *testing.T) {
	var failed *hgros.Error
	if _, err := hgros.Open("sesion: {}", nil); !errors.As(err, &failed) || failed.Code != hgros.ConfigError ||
		failed.Sentence == "" {
		t.Fatal("a wrong configuration gave", err)
	}
	fails(t, errorOf(hgros.OpenFiles([]string{"/no/such.yaml"}, nil)), hgros.ConfigError, "/no/such.yaml")
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

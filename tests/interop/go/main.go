// The peer in Go. ../README.md says what each role does.
package main

import (
	"bufio"
	"context"
	"errors"
	"fmt"
	"os"
	"strconv"
	"strings"
	"time"

	"hgros"
	"hgros_interop/foxglove"
)

const (
	patience = 30 * time.Second
	slice    = 100 * time.Millisecond
	room     = 100
)

func say(format string, values ...interface{}) { fmt.Printf(format+"\n", values...) }

// check and must end the program with the sentence of a failure.
func check(err error) {
	if err != nil {
		panic(err)
	}
}

func must[T any](value T, err error) T {
	check(err)
	return value
}

func text(message string) *foxglove.Log { return &foxglove.Log{Message: message} }

func byteAt(i int) byte { return byte(i*7 + 3) }

// input is the lines of standard input, which a goroutine reads.
type input struct {
	lines chan string
	next  *string
	ended bool
}

func newInput() *input {
	in := &input{lines: make(chan string)}
	go func() {
		scanner := bufio.NewScanner(os.Stdin)
		for scanner.Scan() {
			in.lines <- scanner.Text()
		}
		close(in.lines)
	}()
	return in
}

// waits is whether there is a next line, or the end, before the context ends.
func (in *input) waits(ctx context.Context) bool {
	if in.next != nil || in.ended {
		return true
	}
	select {
	case line, ok := <-in.lines:
		in.next, in.ended = &line, !ok
		return true
	case <-ctx.Done():
		return false
	}
}

func (in *input) waitsFor(timeout time.Duration) bool {
	ctx, cancel := context.WithTimeout(context.Background(), timeout)
	defer cancel()
	return in.waits(ctx)
}

func (in *input) await() { in.waits(context.Background()) }

// take is the next line; false at the end.
func (in *input) take() (string, bool) {
	in.await()
	if in.ended {
		return "", false
	}
	line := *in.next
	in.next = nil
	return line, true
}

type peer struct {
	session *hgros.Session
	in      *input
}

func (p *peer) run(words []string) {
	roles := map[string]func(ctx context.Context, first, second string){
		"publish": p.publish, "subscribe": p.subscribe, "latch": p.latch, "bulk-publish": p.bulkPublish,
		"bulk-subscribe": p.bulkSubscribe, "serve": p.serve, "call": p.call, "misfit": p.misfit,
	}
	if words[0] == "talk" {
		p.talk()
		return
	}
	role, ok := roles[words[0]]
	if !ok {
		panic(fmt.Errorf("There is no role %s.", words[0]))
	}
	ctx, cancel := context.WithTimeout(context.Background(), patience)
	defer cancel()
	words = append(words, "", "")
	role(ctx, words[1], words[2])
}

func (p *peer) talk() {
	say("ready")
	for {
		line, ok := p.in.take()
		if !ok {
			return
		}
		if words := strings.Fields(line); len(words) > 0 {
			p.run(words)
		}
	}
}

func (p *peer) publish(ctx context.Context, channel, count string) {
	most := must(strconv.Atoi(count))
	publisher := must(hgros.Advertise[*foxglove.Log](p.session, channel, nil))
	defer publisher.Close()
	check(p.session.WaitForSubscribers(ctx, channel, 1))
	sent := 0
	for sent < most && !p.in.waitsFor(0) {
		wait, cancel := context.WithTimeout(context.Background(), slice)
		err := publisher.PublishWait(wait, text(strconv.Itoa(sent+1)))
		cancel()
		if errors.Is(err, context.DeadlineExceeded) {
			continue
		}
		check(err)
		if sent++; sent == 1 {
			say("publishing")
		}
	}
	say("published %d", sent)
	p.in.await()
}

func (p *peer) subscribe(_ context.Context, channel, count string) {
	most := must(strconv.Atoi(count))
	queue := must(hgros.Subscribe[*foxglove.Log](p.session, channel, &hgros.SubscribeOptions{KeepAll: room}))
	defer queue.Close()
	received, first, last := 0, "", ""
	for received < most && !p.in.waitsFor(0) {
		wait, cancel := context.WithTimeout(context.Background(), slice)
		log, err := queue.Next(wait)
		cancel()
		if errors.Is(err, context.DeadlineExceeded) {
			continue
		}
		check(err)
		last = log.Message
		if received++; received == 1 {
			first = last
			say("receiving %s", last)
		}
		if first == "1" && last != strconv.Itoa(received) {
			panic(fmt.Errorf("%q came, not %d.", last, received))
		}
	}
	say("received %d %s", received, last)
}

func (p *peer) latch(ctx context.Context, channel, message string) {
	publisher := must(hgros.Advertise[*foxglove.Log](p.session, channel, &hgros.PublishOptions{Latched: 2}))
	defer publisher.Close()
	for _, one := range []string{"old", message, "new"} {
		check(publisher.Publish(text(one)))
	}
	say("latched")
	p.in.await()
}

func (p *peer) bulkPublish(ctx context.Context, channel, size string) {
	count := must(strconv.Atoi(size))
	publisher := must(hgros.Advertise[*foxglove.PointCloud](p.session, channel, nil))
	defer publisher.Close()
	check(p.session.WaitForSubscribers(ctx, channel, 1))
	cloud := &foxglove.PointCloud{PointStride: 1, Data: make([]byte, count)}
	for i := range cloud.Data {
		cloud.Data[i] = byteAt(i)
	}
	check(publisher.PublishWait(ctx, cloud))
	say("published %s", size)
	p.in.await()
}

func (p *peer) bulkSubscribe(ctx context.Context, channel, size string) {
	count := must(strconv.Atoi(size))
	queue := must(hgros.Subscribe[*foxglove.PointCloud](p.session, channel, &hgros.SubscribeOptions{KeepAll: room}))
	defer queue.Close()
	say("subscribed")
	cloud := must(queue.Next(ctx))
	if len(cloud.Data) != count {
		panic(fmt.Errorf("The cloud has %d bytes.", len(cloud.Data)))
	}
	for i, value := range cloud.Data {
		if value != byteAt(i) {
			panic(errors.New("The cloud has other bytes."))
		}
	}
	say("received %s", size)
}

func (p *peer) serve(_ context.Context, name, _ string) {
	service := must(hgros.Serve(p.session, name, func(request *foxglove.Log) (*foxglove.Log, error) {
		if request.Message == "fail" {
			return nil, errors.New("asked to fail")
		}
		return text("re: " + request.Message), nil
	}, nil))
	defer service.Close()
	say("serving")
	p.in.await()
}

func (p *peer) call(ctx context.Context, name, message string) {
	for {
		answer, err := hgros.Call[*foxglove.Log, *foxglove.Log](ctx, p.session, name, text(message))
		if err == nil {
			say("answer %s", answer.Message)
			return
		}
		if !errors.Is(err, hgros.NoServer) {
			say("failed %s", err)
			return
		}
		if p.in.waitsFor(10 * time.Millisecond) {
			panic(fmt.Errorf("Nobody serves %s.", name))
		}
	}
}

func (p *peer) misfit(_ context.Context, channel, _ string) {
	queue := must(hgros.Subscribe[*foxglove.PoseInFrame](p.session, channel, nil))
	defer queue.Close()
	say("subscribed")
	p.in.await()
}

func main() {
	defer func() { // Of must and check.
		if fault := recover(); fault != nil {
			fmt.Fprintf(os.Stderr, "peer: %s\n", fault)
			os.Exit(1)
		}
	}()
	if len(os.Args) < 2 {
		panic("usage: peer ROLE [ARGUMENT...]")
	}
	session := must(hgros.Open(os.Getenv("HGROS_INTEROP_YAML"), nil))
	defer session.Close()
	(&peer{session, newInput()}).run(os.Args[1:])
}

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

func (p *peer) run(words []string) error {
	roles := map[string]func(ctx context.Context, first, second string) error{
		"publish": p.publish, "subscribe": p.subscribe, "latch": p.latch, "late": p.late,
		"bulk-publish": p.bulkPublish, "bulk-subscribe": p.bulkSubscribe, "serve": p.serve, "call": p.call,
		"misfit": p.misfit, "stream": p.stream, "follow": p.follow,
	}
	if words[0] == "talk" {
		return p.talk()
	}
	role, ok := roles[words[0]]
	if !ok {
		return fmt.Errorf("There is no role %s.", words[0])
	}
	ctx, cancel := context.WithTimeout(context.Background(), patience)
	defer cancel()
	words = append(words, "", "")
	return role(ctx, words[1], words[2])
}

func (p *peer) talk() error {
	say("ready")
	for {
		line, ok := p.in.take()
		if !ok {
			return nil
		}
		if words := strings.Fields(line); len(words) > 0 {
			if err := p.run(words); err != nil {
				return err
			}
		}
	}
}

func (p *peer) publish(ctx context.Context, channel, count string) error {
	last, err := strconv.Atoi(count)
	if err != nil {
		return err
	}
	publisher, err := hgros.Advertise[*foxglove.Log](p.session, channel, nil)
	if err != nil {
		return err
	}
	defer publisher.Close()
	if err := p.session.WaitForSubscribers(ctx, channel, 1); err != nil {
		return err
	}
	for i := 1; i <= last; i++ {
		if err := publisher.PublishWait(ctx, text(strconv.Itoa(i))); err != nil {
			return err
		}
	}
	say("published %s", count)
	p.in.await()
	return nil
}

func (p *peer) subscribe(ctx context.Context, channel, count string) error {
	last, err := strconv.Atoi(count)
	if err != nil {
		return err
	}
	queue, err := hgros.Subscribe[*foxglove.Log](p.session, channel, &hgros.SubscribeOptions{KeepAll: room})
	if err != nil {
		return err
	}
	defer queue.Close()
	say("subscribed")
	for i := 1; i <= last; i++ {
		log, err := queue.Next(ctx)
		if err != nil {
			return err
		}
		if log.Message != strconv.Itoa(i) {
			return fmt.Errorf("%q came, not %d.", log.Message, i)
		}
	}
	say("received %s", count)
	return nil
}

func (p *peer) latch(ctx context.Context, channel, message string) error {
	publisher, err := hgros.Advertise[*foxglove.Log](p.session, channel, &hgros.PublishOptions{Latched: 2})
	if err != nil {
		return err
	}
	defer publisher.Close()
	for _, one := range []string{"old", message, "new"} {
		if err := publisher.Publish(text(one)); err != nil {
			return err
		}
	}
	say("latched")
	p.in.await()
	return nil
}

func (p *peer) late(ctx context.Context, channel, _ string) error {
	queue, err := hgros.Subscribe[*foxglove.Log](p.session, channel, nil)
	if err != nil {
		return err
	}
	defer queue.Close()
	log, err := queue.Next(ctx)
	if err != nil {
		return err
	}
	say("late %s", log.Message)
	return nil
}

func (p *peer) bulkPublish(ctx context.Context, channel, size string) error {
	count, err := strconv.Atoi(size)
	if err != nil {
		return err
	}
	publisher, err := hgros.Advertise[*foxglove.PointCloud](p.session, channel, nil)
	if err != nil {
		return err
	}
	defer publisher.Close()
	if err := p.session.WaitForSubscribers(ctx, channel, 1); err != nil {
		return err
	}
	cloud := &foxglove.PointCloud{PointStride: 1, Data: make([]byte, count)}
	for i := range cloud.Data {
		cloud.Data[i] = byteAt(i)
	}
	if err := publisher.PublishWait(ctx, cloud); err != nil {
		return err
	}
	say("published %s", size)
	p.in.await()
	return nil
}

func (p *peer) bulkSubscribe(ctx context.Context, channel, size string) error {
	count, err := strconv.Atoi(size)
	if err != nil {
		return err
	}
	queue, err := hgros.Subscribe[*foxglove.PointCloud](p.session, channel, &hgros.SubscribeOptions{KeepAll: room})
	if err != nil {
		return err
	}
	defer queue.Close()
	say("subscribed")
	cloud, err := queue.Next(ctx)
	if err != nil {
		return err
	}
	if len(cloud.Data) != count {
		return fmt.Errorf("The cloud has %d bytes.", len(cloud.Data))
	}
	sum, expected := 0, 0
	for i, value := range cloud.Data {
		sum += int(value)
		expected += int(byteAt(i))
	}
	if sum != expected || cloud.Data[0] != byteAt(0) || cloud.Data[count-1] != byteAt(count-1) {
		return errors.New("The cloud has other bytes.")
	}
	say("received %s", size)
	return nil
}

func (p *peer) serve(_ context.Context, name, _ string) error {
	service, err := hgros.Serve(p.session, name, func(request *foxglove.Log) (*foxglove.Log, error) {
		if request.Message == "fail" {
			return nil, errors.New("asked to fail")
		}
		return text("re: " + request.Message), nil
	}, nil)
	if err != nil {
		return err
	}
	defer service.Close()
	say("serving")
	p.in.await()
	return nil
}

func (p *peer) call(ctx context.Context, name, message string) error {
	for {
		answer, err := hgros.Call[*foxglove.Log, *foxglove.Log](ctx, p.session, name, text(message))
		if err == nil {
			say("answer %s", answer.Message)
			return nil
		}
		if !errors.Is(err, hgros.NoServer) {
			say("failed %s", err)
			return nil
		}
		if p.in.waitsFor(10 * time.Millisecond) {
			return fmt.Errorf("Nobody serves %s.", name)
		}
	}
}

func (p *peer) misfit(_ context.Context, channel, _ string) error {
	queue, err := hgros.Subscribe[*foxglove.PoseInFrame](p.session, channel, nil)
	if err != nil {
		return err
	}
	defer queue.Close()
	say("subscribed")
	p.in.await()
	return nil
}

func (p *peer) stream(ctx context.Context, channel, _ string) error {
	publisher, err := hgros.Advertise[*foxglove.Log](p.session, channel, nil)
	if err != nil {
		return err
	}
	defer publisher.Close()
	if err := p.session.WaitForSubscribers(ctx, channel, 1); err != nil {
		return err
	}
	sent := 0
	for !p.in.waitsFor(0) {
		wait, cancel := context.WithTimeout(context.Background(), slice)
		err := publisher.PublishWait(wait, text(strconv.Itoa(sent+1)))
		cancel()
		if errors.Is(err, context.DeadlineExceeded) {
			continue
		}
		if err != nil {
			return err
		}
		if sent++; sent == 1 {
			say("streaming")
		}
	}
	say("streamed %d", sent)
	return nil
}

func (p *peer) follow(_ context.Context, channel, _ string) error {
	queue, err := hgros.Subscribe[*foxglove.Log](p.session, channel, &hgros.SubscribeOptions{KeepAll: room})
	if err != nil {
		return err
	}
	defer queue.Close()
	ctx, cancel := context.WithCancel(context.Background())
	defer cancel()
	ended := make(chan error, 1)
	count := 0
	go func() {
		for {
			if _, err := queue.Next(ctx); err != nil {
				ended <- err
				return
			}
			if count++; count == 1 {
				say("following")
			}
		}
	}()
	p.in.await()
	cancel()
	if err := <-ended; !errors.Is(err, context.Canceled) {
		return err
	}
	say("followed %d", count)
	return nil
}

func start() error {
	if len(os.Args) < 2 {
		return errors.New("usage: peer ROLE [ARGUMENT...]")
	}
	session, err := hgros.Open(os.Getenv("HGROS_INTEROP_YAML"), nil)
	if err != nil {
		return err
	}
	defer session.Close()
	return (&peer{session, newInput()}).run(os.Args[1:])
}

func main() {
	if err := start(); err != nil {
		fmt.Fprintf(os.Stderr, "peer: %s\n", err)
		os.Exit(1)
	}
}

package hgros_test

import (
	"os"
	"path/filepath"
	"testing"

	"hgros"
)

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

package hgros_test

import (
	"errors"
	"os"
	"path/filepath"
	"strings"
	"testing"

	"hgros"
)

func TestParametersAreDeclaredSetAndWatched(t *testing.T) {
	session := open(t, nil)
	file := filepath.Join(t.TempDir(), "params.yaml")
	require(t, os.WriteFile(file, []byte("wheel: {radius: 0.25}\n"), 0o600))
	params, err := session.Params(file)
	require(t, err)
	most := 1.0
	require(t, params.Declare("wheel.radius", 0.1, &hgros.ParamInfo{Unit: "m", Most: &most}))
	require(t, params.Declare("wheel.count", 4, nil))
	require(t, params.Declare("name", "it's: \"mine\"", nil))
	require(t, params.Declare("gains", []float64{1, 2.5}, nil))
	require(t, params.Declare("on", true, nil))
	radius, err := params.Number("wheel.radius")
	require(t, err)
	count, err := params.Integer("wheel.count")
	require(t, err)
	name, err := params.Text("name")
	require(t, err)
	on, err := params.Bool("on")
	require(t, err)
	gains, err := params.YAML("gains")
	require(t, err)
	if radius != 0.25 || count != 4 || name != "it's: \"mine\"" || !on || gains != "[1.0, 2.5]" {
		t.Fatal(radius, count, name, on, gains)
	}
	changes := make(chan string, 10)
	watch, err := params.OnChange("wheel", func(path, yaml string) { changes <- path + "=" + yaml })
	require(t, err)
	require(t, params.Set("wheel.radius", 0.5))
	if change := <-changes; change != "wheel.radius=0.5" {
		t.Fatal(change)
	}
	if err := params.Set("wheel.radius", 2.0); !errors.Is(err, hgros.Refused) || !strings.Contains(err.Error(), "1") {
		t.Fatal("a value beyond its bound gave", err)
	}
	if err := params.Set("wheel.radius", struct{}{}); !errors.Is(err, hgros.InvalidArgument) {
		t.Fatal("a value of no kind gave", err)
	}
	inItself := map[string]any{}
	inItself["again"] = inItself
	if err := params.Declare("map", inItself, nil); !errors.Is(err, hgros.InvalidArgument) {
		t.Fatal("a map that contains itself gave", err)
	}
	watch.Close()
	require(t, params.Set("wheel.count", 3))
	if len(changes) != 0 {
		t.Fatal("a closed watch told of", <-changes)
	}
	require(t, params.Close())
	if _, err := params.Bool("on"); !errors.Is(err, hgros.Closed) {
		t.Fatal("closed parameters gave", err)
	}
}

func TestParametersOfAnotherSession(t *testing.T) {
	robot, tool := open(t, &hgros.SessionOptions{Name: "robot"}), open(t, nil)
	own, err := robot.Params()
	require(t, err)
	require(t, own.Declare("speed", 1, nil))
	theirs, err := tool.ParamsOf("robot", patience)
	require(t, err)
	waitUntil(t, "the parameter can be set", func() bool { return theirs.Set("speed", 7) == nil })
	speed, err := own.Integer("speed")
	require(t, err)
	if speed != 7 {
		t.Fatal(speed)
	}
	require(t, theirs.Close())
}

func TestPeersAndChannelsAreSeen(t *testing.T) {
	here := open(t, nil)
	came := make(chan hgros.Peer, 10)
	_, err := here.OnPeer(func(event hgros.PeerEvent, peer hgros.Peer, channel, reason string) {
		if event == hgros.PeerCame {
			came <- peer
		}
	})
	require(t, err)
	_, err = hgros.Subscribe[text](here, "words", nil)
	require(t, err)
	there := open(t, nil)
	_, err = hgros.Advertise[text](there, "words", nil)
	require(t, err)
	require(t, there.WaitForSubscribers(deadline(t), "words", 1))
	select {
	case peer := <-came:
		if peer.ID != there.ID() || peer.PID != int64(os.Getpid()) {
			t.Fatalf("%+v", peer)
		}
	case <-deadline(t).Done():
		t.Fatal("no session came")
	}
	peers, err := here.Peers()
	require(t, err)
	if len(peers) != 1 || peers[0].ID != there.ID() {
		t.Fatalf("%+v", peers)
	}
	waitUntil(t, "the channel is known", func() bool {
		channels, err := here.Channels()
		require(t, err)
		for _, channel := range channels {
			if channel.Name == "words" && channel.TypeName == "google.protobuf.StringValue" && channel.Publishers == 1 {
				return true
			}
		}
		return false
	})
}

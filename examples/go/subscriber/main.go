// Shows messages of any type with the description that comes with the channel: subscriber CHANNEL [COUNT].
package main

import (
	"context"
	"fmt"
	"log"
	"os"
	"os/signal"
	"strconv"

	"hgros"

	"google.golang.org/protobuf/encoding/protojson"
)

func main() {
	if len(os.Args) < 2 {
		log.Fatal("usage: subscriber CHANNEL [COUNT]")
	}
	count := -1
	if len(os.Args) > 2 {
		var err error
		if count, err = strconv.Atoi(os.Args[2]); err != nil {
			log.Fatal(err)
		}
	}
	session, err := hgros.Open("", nil)
	if err != nil {
		log.Fatal(err)
	}
	defer session.Close()
	queue, err := session.SubscribeRaw(os.Args[1], &hgros.SubscribeOptions{KeepAll: 100})
	if err != nil {
		log.Fatal(err)
	}
	ctx, cancel := signal.NotifyContext(context.Background(), os.Interrupt)
	defer cancel()
	for ; count != 0; count-- {
		message, err := queue.Take(ctx)
		if err != nil {
			log.Fatal(err)
		}
		show(message)
	}
}

func show(message *hgros.Message) {
	defer message.Close()
	decoded, err := message.Decode()
	if err != nil {
		fmt.Println(err)
		return
	}
	fmt.Printf("%s: %s\n", decoded.Descriptor().FullName(), protojson.Format(decoded))
}

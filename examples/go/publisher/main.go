// Publishes five greetings as soon as somebody subscribes.
package main

import (
	"context"
	"fmt"
	"log"
	"time"

	"hgros"

	"google.golang.org/protobuf/types/known/wrapperspb"
)

func main() {
	session, err := hgros.Open("", nil)
	if err != nil {
		log.Fatal(err)
	}
	defer session.Close()
	publisher, err := hgros.Advertise[*wrapperspb.StringValue](session, "greetings", &hgros.PublishOptions{Latched: 5})
	if err != nil {
		log.Fatal(err)
	}
	ctx, cancel := context.WithTimeout(context.Background(), time.Minute)
	defer cancel()
	if err := session.WaitForSubscribers(ctx, "greetings", 1); err != nil {
		log.Fatal(err)
	}
	for i := 1; i <= 5; i++ {
		if err := publisher.PublishWait(ctx, wrapperspb.String(fmt.Sprintf("Hello %d", i))); err != nil {
			log.Fatal(err)
		}
	}
	fmt.Println("published")
}

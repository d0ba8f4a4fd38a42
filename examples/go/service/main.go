// Serves the square root of a number, and calls it twice: once with a number that has none.
package main

import (
	"context"
	"errors"
	"fmt"
	"log"
	"math"
	"time"

	"hgros"

	"google.golang.org/protobuf/types/known/wrapperspb"
)

func root(number *wrapperspb.DoubleValue) (*wrapperspb.DoubleValue, error) {
	if number.Value < 0 {
		return nil, errors.New("there is no root of a number below zero")
	}
	return wrapperspb.Double(math.Sqrt(number.Value)), nil
}

func main() {
	session, err := hgros.Open("", nil)
	if err != nil {
		log.Fatal(err)
	}
	defer session.Close()
	if _, err := hgros.Serve(session, "root", root, nil); err != nil {
		log.Fatal(err)
	}
	ctx, cancel := context.WithTimeout(context.Background(), time.Minute)
	defer cancel()
	for _, number := range []float64{16, -1} {
		reply, err := hgros.Call[*wrapperspb.DoubleValue, *wrapperspb.DoubleValue](ctx, session, "root",
			wrapperspb.Double(number))
		if errors.Is(err, hgros.HandlerFailed) {
			fmt.Println(err)
		} else if err != nil {
			log.Fatal(err)
		} else {
			fmt.Printf("The root of %g is %g\n", number, reply.Value)
		}
	}
}

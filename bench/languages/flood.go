// Receives as many messages as its argument says, and prints how many came per second.
package main

import (
	"context"
	"fmt"
	"log"
	"os"
	"strconv"
	"time"

	"hgros"
	"hgros_bench/foxglove"
)

func must(err error) {
	if err != nil {
		log.Fatal(err)
	}
}

func main() {
	flood, err := strconv.Atoi(os.Args[1])
	must(err)
	session, err := hgros.Open("", nil)
	must(err)
	defer session.Close()
	queue, err := hgros.Subscribe[*foxglove.LaserScan](session, "flood", &hgros.SubscribeOptions{KeepAll: 1000})
	must(err)
	var begin time.Time
	for i := 0; i < flood; i++ {
		scan, err := queue.Next(context.Background())
		must(err)
		if scan.StartAngle != float64(i) {
			log.Fatalf("message %v came in place of %v", scan.StartAngle, i)
		}
		if i == 0 {
			begin = time.Now()
		}
	}
	fmt.Printf("%.0f\n", float64(flood)/time.Since(begin).Seconds())
}

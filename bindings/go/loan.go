package hgros

// #include "bridge.h"
import "C"

import (
	"context"
	"unsafe"
)

// Loan is memory to fill and publish. It is where receivers on this host read, so publishing it copies nothing. One
// goroutine at a time uses it. It is not collected: close it.
type Loan struct {
	guard
	handle *C.hgros_loan
	data   []byte
}

// Loan lends memory for one message of a size. Its bytes have arbitrary values at first. It never waits.
func (p *RawPublisher) Loan(size int) (*Loan, error) {
	if size < 0 {
		return nil, &Error{InvalidArgument, "The size of a loan is below zero."}
	}
	loan := &Loan{}
	if err := p.do("publisher", func() C.hgros_status {
		return C.hgros_loan_open(p.handle, C.size_t(size), &loan.handle)
	}); err != nil {
		return nil, err
	}
	var lent C.size_t
	loan.data = unsafe.Slice((*byte)(C.hgros_loan_data(loan.handle, &lent)), size)
	loan.free = func() { C.hgros_loan_free(loan.handle) }
	return loan, nil
}

// Data is the memory to fill, which nobody may use once the loan is published or closed; then it is nil.
func (l *Loan) Data() []byte { return l.data }

// Publish publishes the loan on the channel of its publisher, and closes it. It never waits. If it fails, the loan is as
// it was: Full says that a lossless subscriber has no room.
func (l *Loan) Publish() error { return l.published(l.publish(0)) }

// PublishWait is the same, but waits while a lossless subscriber has no room.
func (l *Loan) PublishWait(ctx context.Context) error { return l.published(poll(ctx, l.publish)) }

func (l *Loan) publish(timeout C.int64_t) error {
	return l.do("loan", func() C.hgros_status { return C.hgros_loan_publish(l.handle, timeout) })
}

func (l *Loan) published(err error) error {
	if err == nil {
		l.Close()
	}
	return err
}

// Close gives back a loan that was not published.
func (l *Loan) Close() {
	l.data = nil
	l.close()
}

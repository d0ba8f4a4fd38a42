<?php

declare(strict_types=1);

namespace Hgros;

use FFI\CData;

/** Publishes bytes of one type on one channel. */
final class RawPublisher extends Handle
{
    private readonly Session $session; // Not forgotten while its publisher is used.

    /** Session::advertiseRaw() makes it. */
    public function __construct(Session $session, string $channel, Schema $schema, int $latched)
    {
        $options = Library::struct('hgros_publish_options', ['latched' => $latched]);
        parent::__construct(Library::create('hgros_publisher', static fn (CData $place): int
            => Library::c()->hgros_publisher_open($session->c(), Library::uncut($channel), $schema->c(),
                \FFI::addr($options),
                $place)));
        $this->session = $session;
    }

    protected function free(CData $handle): void
    {
        Library::c()->hgros_publisher_close($handle);
    }

    /** It never waits: the status Full says that a lossless subscriber has no room. */
    public function publish(string $bytes): void
    {
        Library::check(Library::c()->hgros_publish($this->opened(), $bytes, strlen($bytes)));
    }

    /** The same, but waits while a lossless subscriber has no room. */
    public function publishWait(string $bytes, ?float $timeout = null): void
    {
        Library::check(Library::c()->hgros_publish_wait($this->opened(), $bytes, strlen($bytes),
            Library::nanoseconds($timeout)));
    }

    /** Memory for one message, which receivers on this host read where it is. */
    public function loan(int $size): Loan
    {
        return new Loan($this, Library::create('hgros_loan', fn (CData $place): int
            => Library::c()->hgros_loan_open($this->opened(), $size, $place)));
    }
}

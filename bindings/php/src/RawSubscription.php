<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/**
 * A queue of received messages. `foreach` takes them until the session or the subscription ends.
 *
 * @implements \IteratorAggregate<int, Message>
 */
final class RawSubscription extends Handle implements \IteratorAggregate
{
    private readonly Session $session; // Not forgotten while its subscription is used.

    /** Session::subscribeRaw() makes it. */
    public function __construct(Session $session, string $channel, ?Schema $schema, int $keepLast, int $keepAll,
        int $keepAllBytes, string $name)
    {
        $text = Library::text($name);
        $options = Library::struct('hgros_subscribe_options', ['name' => $text, 'schema' => $schema?->c(),
            'keep_last' => $keepLast, 'keep_all' => $keepAll, 'keep_all_bytes' => $keepAllBytes]);
        parent::__construct(Library::create('hgros_subscription', static fn (CData $place): int
            => Library::c()->hgros_subscribe_queue($session->c(), Library::uncut($channel), FFI::addr($options),
                $place)));
        $this->session = $session;
    }

    protected function free(CData $handle): void
    {
        Library::c()->hgros_subscription_close($handle);
    }

    /** Takes the oldest message, and waits for it. Null if none came in time; Closed once the session has ended. */
    public function take(?float $timeout = null): ?Message
    {
        $queue = $this->opened();
        return $this->tryTake() ?? ($timeout === 0.0 ? null
            : Library::await(Library::c()->hgros_queue_descriptor($queue), $timeout, $this->tryTake(...)));
    }

    private function tryTake(): ?Message
    {
        $place = Library::c()->new('hgros_message*');
        $status = Library::c()->hgros_queue_take($this->opened(), 0, FFI::addr($place));
        if ($status === Status::TimedOut->value) {
            return null;
        }
        Library::check($status);
        return new Message($place);
    }

    public function getIterator(): \Generator
    {
        try {
            while (true) {
                yield $this->take();
            }
        } catch (HgrosException $end) {
            if ($end->status !== Status::Closed) {
                throw $end;
            }
        }
    }

    /**
     * A stream that is readable while messages wait, for stream_select() and event loops: then take(0.0) until it is
     * null. Neither read nor write it. Only in the command line's PHP.
     *
     * @return resource
     */
    public function stream(): mixed
    {
        return Library::stream(Library::c()->hgros_queue_descriptor($this->opened()));
    }

    /** @return array{received: int, dropped: int, taken: int, queued: int, mismatched: int} Counted since it began. */
    public function stats(): array
    {
        $stats = Library::struct('hgros_subscription_stats');
        Library::check(Library::c()->hgros_subscription_get_stats($this->opened(), FFI::addr($stats)));
        return ['received' => $stats->received, 'dropped' => $stats->dropped, 'taken' => $stats->run,
            'queued' => $stats->queued, 'mismatched' => $stats->mismatched];
    }
}

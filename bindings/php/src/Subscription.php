<?php

declare(strict_types=1);

namespace Hgros;

use Google\Protobuf\Internal\Message as ProtobufMessage;

/**
 * A queue of received protobuf messages of one class. `foreach` takes them until the session or the subscription ends.
 *
 * @template T of ProtobufMessage
 * @implements \IteratorAggregate<int, T>
 */
final class Subscription implements \IteratorAggregate
{
    /**
     * Session::subscribe() makes it.
     *
     * @param RawSubscription $raw The same queue: its messages have their bytes and MessageInfo.
     * @param class-string<T> $class
     */
    public function __construct(public readonly RawSubscription $raw, private readonly string $class)
    {
    }

    /**
     * Takes the oldest message, and waits for it. Null if none came in time; Closed once the session has ended.
     *
     * @return ?T
     */
    public function take(?float $timeout = null): ?ProtobufMessage
    {
        return $this->raw->take($timeout)?->read($this->class);
    }

    public function getIterator(): \Generator
    {
        foreach ($this->raw as $message) {
            yield $message->read($this->class);
        }
    }

    /** @return resource As RawSubscription::stream(). */
    public function stream(): mixed
    {
        return $this->raw->stream();
    }

    /** @return array<string, int> As RawSubscription::stats(). */
    public function stats(): array
    {
        return $this->raw->stats();
    }

    /** Ends the subscription. */
    public function close(): void
    {
        $this->raw->close();
    }
}

<?php

declare(strict_types=1);

namespace Hgros;

use Google\Protobuf\Internal\Message as ProtobufMessage;

/**
 * Publishes protobuf messages of one class on one channel.
 *
 * @template T of ProtobufMessage
 */
final class Publisher
{
    /**
     * Session::advertise() makes it.
     *
     * @param class-string<T> $class
     */
    public function __construct(public readonly RawPublisher $raw, private readonly string $class)
    {
    }

    /**
     * It never waits: the status Full says that a lossless subscriber has no room.
     *
     * @param T $message
     */
    public function publish(ProtobufMessage $message): void
    {
        $this->raw->publish($this->bytesOf($message));
    }

    /**
     * The same, but waits while a lossless subscriber has no room.
     *
     * @param T $message
     */
    public function publishWait(ProtobufMessage $message, ?float $timeout = null): void
    {
        $this->raw->publishWait($this->bytesOf($message), $timeout);
    }

    /** Ends the publisher. */
    public function close(): void
    {
        $this->raw->close();
    }

    private function bytesOf(ProtobufMessage $message): string
    {
        if (!$message instanceof $this->class) {
            throw new HgrosException(Status::TypeMismatch,
                'The message is a ' . $message::class . ", but the channel was announced with {$this->class}.");
        }
        return Protobuf::write($message);
    }
}

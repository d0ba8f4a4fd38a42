<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/**
 * A received message: a lease on the sender's memory, which ends when the object is forgotten or closed. Do not keep
 * many large ones.
 */
final class Message extends Handle
{
    /** For the classes here. */
    public function __construct(CData $handle)
    {
        parent::__construct($handle);
    }

    protected function free(CData $handle): void
    {
        Library::c()->hgros_message_free($handle);
    }

    /** The leases of this process. */
    public static function leases(): int
    {
        return Library::c()->hgros_message_leases();
    }

    public function size(): int
    {
        return $this->bytes()[1];
    }

    /** A copy of the bytes, or of a part of them. */
    public function data(int $offset = 0, ?int $length = null): string
    {
        [$data, $size] = $this->bytes();
        $length ??= $size - $offset;
        if ($offset < 0 || $length < 0 || $offset > $size - $length) {
            throw new HgrosException(Status::InvalidArgument,
                "$length bytes at $offset are not in a message of $size bytes.");
        }
        return $length === 0 ? '' : FFI::string(Library::c()->cast('char*', $data) + $offset, $length);
    }

    /**
     * The bytes without a copy, as `const uint8_t*`; null if there are none. Nobody may write them, and nobody may read
     * them once the message is closed or forgotten.
     */
    public function view(): ?CData
    {
        [$data, $size] = $this->bytes();
        return $size === 0 ? null : Library::c()->cast('const uint8_t*', $data);
    }

    /** The name of the sender's type. */
    public function typeName(): string
    {
        return Library::c()->hgros_schema_type_name(Library::c()->hgros_message_schema($this->opened()));
    }

    /** A copy of the sender's type. */
    public function schema(): Schema
    {
        $c = Library::c();
        $came = $c->hgros_message_schema($this->opened());
        $size = $c->new('size_t');
        $set = $c->hgros_schema_descriptor_set($came, FFI::addr($size));
        return Schema::create($c->hgros_schema_type_name($came), Encoding::from($c->hgros_schema_encoding($came)),
            $c->hgros_schema_fingerprint($came), $set === null ? '' : FFI::string($set, $size->cdata));
    }

    /**
     * Decodes the message into an object of its class.
     *
     * @template T of \Google\Protobuf\Internal\Message
     * @param class-string<T> $class
     * @return T
     */
    public function read(string $class): \Google\Protobuf\Internal\Message
    {
        $wanted = Schema::of($class)->typeName();
        if ($this->typeName() !== $wanted) {
            throw new HgrosException(Status::TypeMismatch,
                "The message is a \"{$this->typeName()}\", but is read as \"$wanted\".");
        }
        $message = new $class();
        try {
            $message->mergeFromString($this->data());
        } catch (\Exception $error) {
            throw new HgrosException(Status::NotWritable, "The message cannot be read as $wanted: "
                . $error->getMessage(), $error);
        }
        return $message;
    }

    public function info(): MessageInfo
    {
        $info = Library::struct('hgros_message_info');
        Library::check(Library::c()->hgros_message_get_info($this->opened(), FFI::addr($info)));
        return new MessageInfo($info->remote !== 0, $info->publisher, $info->sequence, $info->key,
            $info->publish_time_ns);
    }

    /** @return array{?CData, int} */
    private function bytes(): array
    {
        $size = Library::c()->new('size_t');
        return [Library::c()->hgros_message_data($this->opened(), FFI::addr($size)), $size->cdata];
    }
}

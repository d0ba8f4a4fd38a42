<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/** The type of messages. It never changes. */
final class Schema extends Handle
{
    /** @var array<class-string, self> */
    private static array $known = [];

    /** @param class-string<\Google\Protobuf\Internal\Message> $class A class that protoc has generated. */
    public static function of(string $class): self
    {
        return self::$known[$class] ??= self::create(Protobuf::typeName($class), Encoding::Protobuf, 0,
            Protobuf::descriptorSet($class));
    }

    /**
     * A type of your own whose bytes the library does not know. Without a fingerprint, types are compared by name and
     * encoding alone.
     */
    public static function raw(string $typeName, Encoding $encoding = Encoding::Custom, int $fingerprint = 0): self
    {
        return self::create($typeName, $encoding, $fingerprint, '');
    }

    /** A protobuf type that comes with the library, such as "foxglove.Log". */
    public static function named(string $typeName): self
    {
        return new self(Library::create('hgros_schema', static fn (CData $place): int
            => Library::c()->hgros_schema_known(Library::uncut($typeName), $place)));
    }

    /** @param string $set A serialized google.protobuf.FileDescriptorSet, imports first; empty: none. */
    public static function create(string $typeName, Encoding $encoding, int $fingerprint, string $set): self
    {
        return new self(Library::create('hgros_schema', static fn (CData $place): int
            => Library::c()->hgros_schema_create(Library::uncut($typeName), $encoding->value, $fingerprint,
                $set === '' ? null : $set, strlen($set), $place)));
    }

    protected function free(CData $handle): void
    {
        Library::c()->hgros_schema_free($handle);
    }

    /** For the classes here. */
    public function c(): CData
    {
        return $this->opened();
    }

    public function typeName(): string
    {
        return Library::c()->hgros_schema_type_name($this->opened());
    }

    public function encoding(): Encoding
    {
        return Encoding::from(Library::c()->hgros_schema_encoding($this->opened()));
    }

    /** Equal for equal types; 0: unknown. */
    public function fingerprint(): int
    {
        return Library::c()->hgros_schema_fingerprint($this->opened());
    }

    /** A serialized google.protobuf.FileDescriptorSet; empty: the type has none. */
    public function descriptorSet(): string
    {
        $size = Library::c()->new('size_t');
        $set = Library::c()->hgros_schema_descriptor_set($this->opened(), FFI::addr($size));
        return $set === null ? '' : FFI::string($set, $size->cdata);
    }
}

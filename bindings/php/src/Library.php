<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/** The C interface, and the ways in which PHP values get there. For the classes here. */
final class Library
{
    // What waits for a descriptor with poll(), which signals interrupt, so that their handlers in PHP run.
    private const POLL = 'typedef struct { int fd; short events; short revents; } hgros_php_pollfd;
        int poll(hgros_php_pollfd* one, unsigned long count, int timeout_ms);';
    private const POLLIN = 1;
    private const SLICE_MS = 200;

    private static ?FFI $c = null;

    public static function c(): FFI
    {
        return self::$c ??= self::load();
    }

    private static function load(): FFI
    {
        [$path, $declarations] = require __DIR__ . '/../interface.php';
        return FFI::cdef($declarations . self::POLL, $path);
    }

    public static function check(int $status): void
    {
        if ($status !== 0) {
            throw new HgrosException(Status::tryFrom($status) ?? Status::Error, self::c()->hgros_last_error());
        }
    }

    /** A pointer that a function of the library fills in. */
    public static function create(string $type, callable $call): CData
    {
        $place = self::c()->new("$type*");
        self::check($call(FFI::addr($place)));
        return $place;
    }

    /** A struct with its size, and its fields from an array. Texts must be CData that live as long as the struct. */
    public static function struct(string $type, array $fields = []): CData
    {
        $struct = self::c()->new($type);
        $struct->size = FFI::sizeof($struct);
        foreach ($fields as $name => $value) {
            if (is_int($value)) {
                self::count($value, $name);
            }
            $struct->$name = $value instanceof CData && FFI::typeof($value)->getKind() === FFI\CType::TYPE_ARRAY
                ? self::c()->cast('char*', $value) : $value;
        }
        return $struct;
    }

    /** C would take a number below zero for a huge one. */
    public static function count(int $count, string $name = 'count'): int
    {
        return $count >= 0 ? $count
            : throw new HgrosException(Status::InvalidArgument, "$name is $count, but must not be below zero.");
    }

    /** C would cut a text at U+0000. */
    public static function uncut(string $text): string
    {
        return !str_contains($text, "\0") ? $text : throw new HgrosException(Status::InvalidArgument,
            'The text "' . str_replace("\0", '\0', $text) . '" has the character U+0000, which no text here may have.');
    }

    /** A text in memory of C, or null for an empty one. */
    public static function text(string $text): ?CData
    {
        if (self::uncut($text) === '') {
            return null;
        }
        $memory = self::c()->new('char[' . strlen($text) + 1 . ']');
        FFI::memcpy($memory, $text, strlen($text));
        return $memory;
    }

    /**
     * Calls a function with texts as `const char* const*`, which is null if there are none.
     *
     * @param list<string> $texts
     */
    public static function withTexts(array $texts, callable $call): mixed
    {
        if ($texts === []) {
            return $call(null);
        }
        $list = self::c()->new('const char*[' . count($texts) . ']');
        $kept = [];
        foreach (array_values($texts) as $i => $text) {
            $kept[$i] = self::text($text) ?? self::c()->new('char[1]');
            $list[$i] = self::c()->cast('char*', $kept[$i]);
        }
        return $call(self::c()->cast('const char**', $list));
    }

    /** A text that the library made, which is freed. */
    public static function taken(CData $text): string
    {
        $copy = FFI::string($text);
        self::c()->hgros_text_free($text);
        return $copy;
    }

    /** Seconds as the library takes them; null is for ever. */
    public static function nanoseconds(?float $seconds): int
    {
        return $seconds === null ? -1 : (int) max(0.0, min($seconds, 9.0e9) * 1e9);
    }

    /**
     * Takes what waits at a descriptor, or waits for it. `$take` returns what it took, or null if there is nothing yet.
     */
    public static function await(int $descriptor, ?float $timeout, callable $take): mixed
    {
        $end = $timeout === null ? null : hrtime(true) + self::nanoseconds($timeout);
        while (($taken = $take()) === null) {
            $left = $end === null ? null : $end - hrtime(true);
            if ($left !== null && $left <= 0) {
                return null;
            }
            $one = self::c()->new('hgros_php_pollfd');
            $one->fd = $descriptor;
            $one->events = self::POLLIN;
            // A signal that comes right before poll() does not end it, so its handler runs after a slice.
            self::c()->poll(FFI::addr($one), 1, (int) min(ceil(($left ?? INF) / 1e6), self::SLICE_MS));
        }
        return $taken;
    }

    /** @return resource A stream that is readable with a descriptor, for stream_select(). */
    public static function stream(int $descriptor): mixed
    {
        return fopen("php://fd/$descriptor", 'r')
            ?: throw new HgrosException(Status::Error, "Descriptor $descriptor cannot be opened as a stream.");
    }
}

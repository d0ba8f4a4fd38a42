<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/** A channel that sessions use. */
final class Channel
{
    /**
     * @param string $name Channels of the library itself begin with "hgros/".
     * @param string $typeName Empty: unknown.
     * @param int $fingerprint 0: unknown.
     */
    public function __construct(
        public readonly string $name,
        public readonly string $typeName,
        public readonly int $fingerprint,
        public readonly Encoding $encoding,
        public readonly int $publishers,
        public readonly int $subscribers,
    ) {
    }

    /** @return list<self> */
    public static function all(Session $session): array
    {
        $c = Library::c();
        $list = Library::create('hgros_channels', static fn (CData $place): int
            => $c->hgros_channels_open($session->c(), $place));
        try {
            $all = [];
            for ($i = 0; $i < $c->hgros_channels_count($list); ++$i) {
                $one = Library::struct('hgros_channel');
                Library::check($c->hgros_channels_get($list, $i, FFI::addr($one)));
                $all[] = new self($one->name, $one->type_name, $one->fingerprint, Encoding::from($one->encoding),
                    $one->publishers, $one->subscribers);
            }
            return $all;
        } finally {
            $c->hgros_channels_free($list);
        }
    }
}

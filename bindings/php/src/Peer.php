<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/** A session that is connected with one. */
final class Peer
{
    /**
     * @param string $transport Of its messages: "shared memory" or "ZeroMQ".
     * @param string $why Why that transport was chosen, such as "same host".
     */
    public function __construct(
        public readonly int $id,
        public readonly string $process,
        public readonly string $host,
        public readonly int $pid,
        public readonly string $transport,
        public readonly string $why,
    ) {
    }

    /** @return list<self> */
    public static function all(Session $session): array
    {
        $c = Library::c();
        $list = Library::create('hgros_peers', static fn (CData $place): int
            => $c->hgros_peers_open($session->c(), $place));
        try {
            $all = [];
            for ($i = 0; $i < $c->hgros_peers_count($list); ++$i) {
                $one = Library::struct('hgros_peer');
                Library::check($c->hgros_peers_get($list, $i, FFI::addr($one)));
                $all[] = new self($one->id, $one->process, $one->host, $one->pid, $one->transport, $one->why);
            }
            return $all;
        } finally {
            $c->hgros_peers_free($list);
        }
    }
}

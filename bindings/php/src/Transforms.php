<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/** The transforms of a session: what it sets, which other sessions get, and what it receives. */
final class Transforms extends Handle
{
    private readonly Session $session; // Not forgotten while its transforms are used.

    /** Session::transforms() makes it. */
    public function __construct(Session $session)
    {
        parent::__construct(Library::create('hgros_transforms', static fn (CData $place): int
            => Library::c()->hgros_transforms_open($session->c(), $place)));
        $this->session = $session;
    }

    protected function free(CData $handle): void
    {
        Library::check(Library::c()->hgros_transforms_close($handle));
    }

    /** Sets and sends the pose of a child frame in its parent at the pose's stamp. */
    public function set(string $parent, string $child, Transform $pose): void
    {
        Library::check(Library::c()->hgros_transforms_set($this->opened(), Library::uncut($parent),
            Library::uncut($child), FFI::addr(self::toC($pose))));
    }

    /** The same for a pose that does not move: sessions that join later get it, too. */
    public function setStatic(string $parent, string $child, Transform $pose): void
    {
        Library::check(Library::c()->hgros_transforms_set_static($this->opened(), Library::uncut($parent),
            Library::uncut($child), FFI::addr(self::toC($pose))));
    }

    /** The transform from a source frame to a target, at a time in ns, or at the latest that all edges between have. */
    public function lookup(string $target, string $source, ?int $time = null): Transform
    {
        Library::uncut($target);
        Library::uncut($source);
        return self::found(fn (CData $found): int => $time === null
            ? Library::c()->hgros_transforms_lookup($this->opened(), $target, $source, $found)
            : Library::c()->hgros_transforms_lookup_at($this->opened(), $target, $source, $time, $found));
    }

    /** The same at a time in ns, but waits until it is there. TimedOut tells why it is not. */
    public function wait(string $target, string $source, int $time = 0, ?float $timeout = null): Transform
    {
        return self::found(fn (CData $found): int => Library::c()->hgros_transforms_wait($this->opened(),
            Library::uncut($target), Library::uncut($source), $time, Library::nanoseconds($timeout), $found));
    }

    private static function toC(Transform $pose): CData
    {
        if (count($pose->translation) !== 3 || count($pose->rotation) !== 4) {
            throw new HgrosException(Status::InvalidArgument,
                'A transform has 3 numbers of translation and 4 of rotation.');
        }
        $c = Library::c()->new('hgros_transform');
        foreach (array_values($pose->translation) as $i => $value) {
            $c->translation[$i] = $value;
        }
        foreach (array_values($pose->rotation) as $i => $value) {
            $c->rotation[$i] = $value;
        }
        $c->stamp_ns = $pose->stamp;
        return $c;
    }

    private static function found(callable $look): Transform
    {
        $found = Library::c()->new('hgros_transform');
        Library::check($look(FFI::addr($found)));
        [$position, $turn] = [$found->translation, $found->rotation];
        return new Transform([$position[0], $position[1], $position[2]], [$turn[0], $turn[1], $turn[2], $turn[3]],
            $found->stamp_ns);
    }
}

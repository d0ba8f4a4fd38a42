<?php

declare(strict_types=1);

namespace Hgros;

/** p_target = rotation * p_source + translation. */
final class Transform
{
    /**
     * @param array{float, float, float} $translation x, y, z in meters.
     * @param array{float, float, float, float} $rotation A unit quaternion: x, y, z, w.
     * @param int $stamp In ns: the time at which it holds; 0 if only static transforms connect the frames.
     */
    public function __construct(
        public readonly array $translation,
        public readonly array $rotation = [0.0, 0.0, 0.0, 1.0],
        public readonly int $stamp = 0,
    ) {
    }
}

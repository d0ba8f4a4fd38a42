<?php

declare(strict_types=1);

namespace Hgros;

/** Where a message comes from. */
final class MessageInfo
{
    /**
     * @param bool $remote From another session.
     * @param int $publisher The sender's session id.
     * @param int $sequence Counts the sender's messages on the channel.
     * @param int $key Names the message in all processes.
     * @param int $publishTime The sender's wall clock in ns; 0 for messages of the same session.
     */
    public function __construct(
        public readonly bool $remote,
        public readonly int $publisher,
        public readonly int $sequence,
        public readonly int $key,
        public readonly int $publishTime,
    ) {
    }
}

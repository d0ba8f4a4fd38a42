<?php

declare(strict_types=1);

namespace Hgros;

/** What everything here throws when the library refuses. The message is a sentence: what is wrong, how to mend it. */
final class HgrosException extends \RuntimeException
{
    public function __construct(public readonly Status $status, string $sentence, ?\Throwable $cause = null)
    {
        parent::__construct($sentence, $status->value, $cause);
    }
}

<?php

declare(strict_types=1);

namespace Hgros;

use FFI\CData;

/** An object of the library, which ends when it is closed or forgotten. */
abstract class Handle
{
    private ?CData $handle;

    protected function __construct(CData $handle)
    {
        $this->handle = $handle;
    }

    final public function __destruct()
    {
        $this->close();
    }

    private function __clone()
    {
    }

    /** Ends it. Later calls throw with the status Closed. It may be called twice. */
    public function close(): void
    {
        $handle = $this->handle ?? null;
        $this->handle = null;
        if ($handle !== null) {
            $this->free($handle);
        }
    }

    abstract protected function free(CData $handle): void;

    final protected function opened(): CData
    {
        return $this->handle
            ?? throw new HgrosException(Status::Closed, 'This ' . static::class . ' was closed before.');
    }
}

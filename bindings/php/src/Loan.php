<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/** Memory for one large message, to fill piece by piece and publish without a copy. */
final class Loan extends Handle
{
    private readonly RawPublisher $publisher; // Not forgotten while its loan is filled.

    /** RawPublisher::loan() makes it. */
    public function __construct(RawPublisher $publisher, CData $handle)
    {
        parent::__construct($handle);
        $this->publisher = $publisher;
    }

    protected function free(CData $handle): void
    {
        Library::c()->hgros_loan_free($handle);
    }

    /** Copies bytes to a place in the message. */
    public function write(string $bytes, int $offset = 0): void
    {
        $size = Library::c()->new('size_t');
        $data = Library::c()->hgros_loan_data($this->opened(), FFI::addr($size));
        if ($data === null) {
            throw new HgrosException(Status::InvalidArgument, 'The loan is published already.');
        }
        if ($offset < 0 || $offset > $size->cdata - strlen($bytes)) {
            throw new HgrosException(Status::InvalidArgument,
                strlen($bytes) . " bytes at $offset are not in a loan of {$size->cdata} bytes.");
        }
        if ($bytes !== '') {
            FFI::memcpy(Library::c()->cast('char*', $data) + $offset, $bytes, strlen($bytes));
        }
    }

    /** Publishes it. With a timeout of 0 it never waits, and throws Full; then the loan is as it was. */
    public function publish(?float $timeout = 0.0): void
    {
        Library::check(Library::c()->hgros_loan_publish($this->opened(), Library::nanoseconds($timeout)));
        $this->close();
    }
}

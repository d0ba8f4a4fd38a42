<?php

declare(strict_types=1);

namespace Hgros;

use Google\Protobuf\Internal\CodedOutputStream;

/** Where protobuf writes a message: a string that grows, instead of an array that is filled byte by byte. */
final class StringOutput extends CodedOutputStream
{
    private string $data = '';

    public function __construct()
    {
    }

    public function getData()
    {
        return $this->data;
    }

    public function writeVarint32($value, $trim)
    {
        return $this->writeVarint64($value);
    }

    public function writeVarint64($value)
    {
        $left = (int) $value;
        while ($left >= 0x80 || $left < 0) {
            $this->data .= chr($left & 0x7f | 0x80);
            $left = $left >> 7 & PHP_INT_MAX >> 6; // The sign does not move along.
        }
        $this->data .= chr($left);
        return true;
    }

    public function writeLittleEndian32($value)
    {
        $this->data .= pack('V', $value);
        return true;
    }

    public function writeLittleEndian64($value)
    {
        $this->data .= pack('P', $value);
        return true;
    }

    public function writeTag($tag)
    {
        return $this->writeVarint64($tag);
    }

    public function writeRaw($data, $size)
    {
        $this->data .= strlen($data) === $size ? $data : substr($data, 0, $size);
        return true;
    }
}

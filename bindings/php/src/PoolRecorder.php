<?php

declare(strict_types=1);

namespace Hgros;

/** Takes the place of protobuf's pool for a moment, and keeps the file that generated code adds. */
final class PoolRecorder extends \Google\Protobuf\Internal\DescriptorPool
{
    public string $added = ''; // A serialized FileDescriptorSet.

    public function internalAddGeneratedFile($data, $use_nested = false)
    {
        $this->added = $data;
    }
}

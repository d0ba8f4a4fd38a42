<?php

declare(strict_types=1);

namespace Hgros;

use Google\Protobuf\Internal\DescriptorPool;
use Google\Protobuf\Internal\FileDescriptorProto;
use Google\Protobuf\Internal\FileDescriptorSet;
use Google\Protobuf\Internal\Message;

/** What Google's protobuf for PHP does not offer: fast writing, and the descriptions of its classes. */
final class Protobuf
{
    /** The bytes of a message. Protobuf's own function copies a text byte by byte. */
    public static function write(Message $message): string
    {
        try {
            if (!method_exists($message, 'serializeToStream')) { // The extension of that name is fast.
                return $message->serializeToString();
            }
            $output = new StringOutput();
            $message->serializeToStream($output);
            return $output->getData();
        } catch (\Exception $error) {
            throw new HgrosException(Status::NotWritable, $message::class . ' cannot be written: '
                . $error->getMessage(), $error);
        }
    }

    /** @param class-string<Message> $class */
    public static function typeName(string $class): string
    {
        self::requireMessage($class);
        new $class(); // Adds its file to the pool.
        return \Google\Protobuf\DescriptorPool::getGeneratedPool()->getDescriptorByClassName($class)->getFullName();
    }

    private static function requireMessage(string $class): void
    {
        if (!is_subclass_of($class, Message::class)) {
            throw new HgrosException(Status::InvalidArgument,
                "$class is not a class of protobuf messages. Generate one with protoc --php_out.");
        }
    }

    /**
     * A serialized FileDescriptorSet of a class: its file after all imports. The generated code has it, but gives it
     * only to protobuf's pool.
     *
     * @param class-string<Message> $class
     */
    public static function descriptorSet(string $class): string
    {
        self::requireMessage($class);
        new $class(); // Its file and all imports are in the pool.
        $constructor = (new \ReflectionClass($class))->getConstructor();
        $lines = array_slice(file($constructor->getFileName()), $constructor->getStartLine() - 1,
            $constructor->getEndLine() - $constructor->getStartLine() + 1);
        $files = [];
        foreach (self::initializedIn(implode('', $lines)) as $metadata) {
            self::addFile($metadata, $files);
        }
        return self::write(new FileDescriptorSet(['file' => array_values($files)]));
    }

    /** @return list<class-string> The classes of files that generated code initializes. */
    private static function initializedIn(string $code): array
    {
        preg_match_all('/^\s*\\\\([\w\\\\]+)::initOnce\(\);/m', $code, $found);
        return $found[1];
    }

    /**
     * Adds a file behind its imports.
     *
     * @param class-string $metadata
     * @param array<class-string, FileDescriptorProto> $files
     */
    private static function addFile(string $metadata, array &$files): void
    {
        if (isset($files[$metadata])) {
            return;
        }
        $imports = [];
        foreach (self::initializedIn(file_get_contents((new \ReflectionClass($metadata))->getFileName())) as $import) {
            self::addFile($import, $files);
            $imports[] = $files[$import]->getName();
        }
        $file = self::recorded($metadata);
        $file->setDependency($imports); // protoc 3.21 leaves out the first one.
        $files[$metadata] = $file;
    }

    /**
     * Lets generated code add its file once more, to a pool that keeps it.
     *
     * @param class-string $metadata
     */
    private static function recorded(string $metadata): FileDescriptorProto
    {
        $pool = new \ReflectionProperty(DescriptorPool::class, 'pool');
        $own = $pool->getValue();
        $recorder = new PoolRecorder();
        $pool->setValue(null, $recorder);
        try {
            $metadata::$is_initialized = false;
            $metadata::initOnce();
        } finally {
            $metadata::$is_initialized = true;
            $pool->setValue(null, $own);
        }
        $set = new FileDescriptorSet();
        $set->mergeFromString($recorder->added);
        return $set->getFile()[0];
    }
}

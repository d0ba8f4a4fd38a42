<?php
// Makes PHP find the classes of the binding, of the messages that come with it, and of Debian's protobuf.

declare(strict_types=1);

spl_autoload_register(static function (string $class): void {
    if (!preg_match('/^(GPBMetadata\\\\)?(Hgros|Foxglove|Google\\\\Protobuf)\\\\/', $class, $found)) {
        return;
    }
    $path = strtr($class, '\\', '/') . '.php';
    $places = $found[2] === 'Google\\Protobuf'
        ? [stream_resolve_include_path($path)]
        : [__DIR__ . '/src/' . substr($path, strlen('Hgros/')), __DIR__ . "/messages/$path"];
    foreach ($places as $place) {
        if ($place !== false && is_file($place)) {
            require $place;
            return;
        }
    }
});

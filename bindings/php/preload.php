<?php
// For opcache.preload: the binding then works in a web server whose scripts may not use FFI (ffi.enable=preload).

declare(strict_types=1);

require_once __DIR__ . '/autoload.php';
foreach (glob(__DIR__ . '/src/*.php') as $file) {
    class_exists('Hgros\\' . basename($file, '.php'));
}

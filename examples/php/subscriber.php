<?php
// Shows the messages of a channel as JSON, with the class of their type: subscriber.php CHANNEL [COUNT].

use Hgros\Session;

if ($argc < 2) {
    exit("usage: subscriber.php CHANNEL [COUNT]\n");
}
$left = (int) ($argv[2] ?? -1);
foreach (Session::open()->subscribeRaw($argv[1], keepAll: 100) as $message) {
    $class = strtr(ucwords($message->typeName(), '.'), '.', '\\'); // foxglove.Log is Foxglove\Log.
    $shown = class_exists($class) ? $message->read($class)->serializeToJsonString() : "{$message->size()} bytes";
    echo "{$message->typeName()}: $shown\n";
    if (--$left === 0) {
        break;
    }
}

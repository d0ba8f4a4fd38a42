<?php
// Publishes five greetings as soon as somebody subscribes.

use Foxglove\Log;
use Hgros\Session;

$session = Session::open();
$publisher = $session->advertise('greetings', Log::class, latched: 5);
$session->waitForSubscribers('greetings', 1, 60.0);
for ($i = 1; $i <= 5; ++$i) {
    $publisher->publish(new Log(['message' => "Hello $i"]));
}
echo "published\n";

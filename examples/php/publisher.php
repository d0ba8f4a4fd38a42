<?php
// Publishes five greetings, which nobody has to wait for: the channel keeps the newest ones for late subscribers.

use Foxglove\Log;
use Hgros\Session;

$session = Session::open();
$publisher = $session->advertise('greetings', Log::class, latched: 5);
for ($i = 1; $i <= 5; ++$i) {
    $publisher->publish(new Log(['message' => "Hello $i"]));
}
$session->waitForSubscribers('greetings', 1, 60.0);
echo "published\n";

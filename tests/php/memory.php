<?php

declare(strict_types=1);

use Foxglove\Log;
use Hgros\Message;
use Hgros\Schema;
use Hgros\Session;

/** In a process of its own: other tests leave memory behind. */
function MemoryStaysBoundedOverManyMessages(): void
{
    $session = Session::open();
    $schema = Schema::raw('bytes');
    $queue = $session->subscribeRaw('bytes', $schema);
    $typed = $session->subscribe('words', Log::class);
    $publisher = $session->advertiseRaw('bytes', $schema);
    $words = $session->advertise('words', Log::class);
    $bytes = str_repeat('x', 1000);
    $residentKb = static fn (): int => (int) preg_replace('/.*VmRSS:\s*(\d+).*/s', '$1',
        file_get_contents('/proc/self/status'));
    for ($i = 0; $i < 55_000; ++$i) {
        if ($i === 5_000) {
            [$php, $resident] = [memory_get_usage(), $residentKb()];
        }
        $publisher->publish($bytes);
        expectEqual(1000, strlen($queue->take(PATIENCE)->data()));
        if ($i % 10 === 0) {
            $words->publish(text('x'));
            $typed->take(PATIENCE);
        }
    }
    expectEqual(0, Message::leases());
    expect(memory_get_usage() - $php < 50_000, memory_get_usage() - $php);
    expect($residentKb() - $resident < 4096, $residentKb() - $resident);
}

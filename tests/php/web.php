<?php

declare(strict_types=1);

/** Answers a request of the web with what the service "ask" says, in a session of its own. */
if (PHP_SAPI !== 'cli') {
    require ini_get('auto_prepend_file'); // Which this server ignores.
    $session = Hgros\Session::open('', 'of the web');
    $reply = $session->call('ask', new Foxglove\Log(['message' => $_GET['text']]), Foxglove\Log::class, 40.0);
    if ($_GET['text'] === 'fatal') {
        $publisher = $session->advertise('seen', Foxglove\Log::class);
        $session->waitForSubscribers('seen', 1, 40.0);
        $publisher->publish(new Foxglove\Log(['message' => 'here']));
        ini_set('memory_limit', '64M');
        str_repeat('x', 1 << 30);
    }
    $session->close();
    echo $reply->getMessage();
    return;
}

function WebRequestsCallAServiceInShortSessions(): void
{
    callFromTheWeb('-d', 'ffi.enable=1');
}

function PreloadedBindingNeedsNoPermissionOfScripts(): void
{
    $preload = dirname(ini_get('auto_prepend_file')) . '/preload.php';
    $user = posix_getpwuid(posix_geteuid())['name'];
    callFromTheWeb('-d', 'ffi.enable=preload', '-d', 'opcache.enable_cli=1', '-d', "opcache.preload=$preload", '-d',
        "opcache.preload_user=$user");
}

function callFromTheWeb(string ...$options): void
{
    $server = Program::peer('serve', 'ask');
    expectEqual('serving', $server->line());
    // An address of this process's own, so that nobody takes the port before the server does.
    $number = getmypid();
    $host = '127.' . (128 | $number >> 15 & 127) . '.' . ($number >> 8 & 127) . '.' . ($number & 255);
    $listener = stream_socket_server("tcp://$host:0");
    $address = stream_socket_get_name($listener, false);
    fclose($listener);
    $web = new Program(PHP_BINARY, '-d', 'auto_prepend_file=' . ini_get('auto_prepend_file'), ...$options,
        ...['-S', $address, __FILE__]);
    awaitUntil('the web server answers', static fn (): bool => @fsockopen("tcp://$address") !== false);
    for ($i = 0; $i < 20; ++$i) {
        expectEqual("re: request $i", file_get_contents("http://$address/?text=request%20$i"));
    }
    $session = Hgros\Session::open();
    $seen = $session->subscribe('seen', Foxglove\Log::class);
    @file_get_contents("http://$address/?text=fatal");
    expectEqual('here', $seen->take(PATIENCE)->getMessage());
    awaitUntil('the session has ended', static fn (): bool => $session->peers() === []);
    expectEqual('re: after', file_get_contents("http://$address/?text=after"));
    $server->finish();
}

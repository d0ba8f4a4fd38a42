<?php

declare(strict_types=1);

use Foxglove\Log;
use Foxglove\PoseInFrame;
use Hgros\LogLevel;
use Hgros\Schema;
use Hgros\Session;
use Hgros\Status;
use Hgros\Transform;

function ErrorsHaveAStatusAndASentence(): void
{
    expectFailure(Status::ConfigError, 'sesion', static fn () => Session::open('sesion: {}'));
    expectFailure(Status::ConfigError, '/no/such.yaml', static fn () => Session::openFiles(['/no/such.yaml']));
    expectFailure(Status::Error, '', static fn () => Session::open()->advertise('a channel', Log::class));
    $session = Session::open('', 'robot');
    expectEqual('robot', $session->name());
    expectFailure(Status::TimedOut, 'words', static function () use ($session): void {
        $publisher = $session->advertise('words', Log::class);
        $session->waitForSubscribers('words', 1, 0.01);
    });
    expectFailure(Status::InvalidArgument, 'keep_all', static fn () => $session->subscribeRaw('words', null, 0, -1));
    expectFailure(Status::InvalidArgument, 'latched', static fn () => $session->advertise('words', Log::class, -1));
    expectFailure(Status::InvalidArgument, 'count', static fn () => $session->waitForPublishers('words', -1));
    $session->setLogLevel(LogLevel::Error);
    $session->log(LogLevel::Info, 'This is not written.');
}

function TextsThatCWouldCutAreRefused(): void
{
    $cut = "words\0more";
    $session = Session::open();
    $params = $session->params();
    $transforms = $session->transforms();
    $pose = new Transform([0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
    $uses = [
        static fn () => Session::open("{}\0"),
        static fn () => Session::open('', $cut),
        static fn () => Session::openFiles([$cut]),
        static fn () => $session->log(LogLevel::Info, $cut),
        static fn () => $session->advertise($cut, Log::class),
        static fn () => $session->subscribe($cut, Log::class),
        static fn () => $session->subscribe('words', Log::class, name: $cut),
        static fn () => $session->waitForSubscribers($cut, 1, PATIENCE),
        static fn () => $session->waitForPublishers($cut, 1, PATIENCE),
        static fn () => $session->serve($cut, Log::class, Log::class, static fn (Log $request) => $request),
        static fn () => $session->call($cut, new Log(), Log::class, PATIENCE),
        static fn () => $session->paramsOf($cut, PATIENCE),
        static fn () => Schema::named($cut),
        static fn () => Schema::raw($cut),
        static fn () => $params->declare($cut, 1),
        static fn () => $params->declare('a', $cut),
        static fn () => $params->declare('a', 'b', $cut),
        static fn () => $params->declare('a', 'b', '', $cut),
        static fn () => $params->declare('a', 'b', choices: ['b', $cut]),
        static fn () => $params->set('a', $cut),
        static fn () => $params->set($cut, 1),
        static fn () => $params->setYaml('a', $cut),
        static fn () => $params->yaml($cut),
        static fn () => $params->remove($cut),
        static fn () => $transforms->setStatic('map', $cut, $pose),
        static fn () => $transforms->set($cut, 'base', $pose),
        static fn () => $transforms->lookup('map', $cut),
        static fn () => $transforms->wait('map', $cut, 0, PATIENCE),
    ];
    foreach ($uses as $use) {
        expectFailure(Status::InvalidArgument, 'has the character U+0000', $use);
    }
}

function HandlesCannotBeCopied(): void
{
    $session = Session::open();
    foreach ([static fn () => clone $session, static fn () => serialize($session)] as $copy) {
        try {
            $copy();
        } catch (Throwable) {
            continue;
        }
        throw new RuntimeException('A session was copied.');
    }
    expect($session->id() !== 0);
}

function FilesAreMerged(): void
{
    $file = tempnam(sys_get_temp_dir(), 'hgros');
    file_put_contents($file, "data_graph: {threads: 1}\n");
    try {
        expectEqual('from file', Session::openFiles([$file, $file], 'from file')->name());
    } finally {
        unlink($file);
    }
}

function ClosedObjectsThrow(): void
{
    [$session, $other] = pair();
    $schema = Schema::raw('bytes');
    $publisher = $session->advertiseRaw('bytes', $schema);
    $queue = $session->subscribeRaw('bytes');
    $service = $session->serve('ask', Log::class, Log::class, static fn (Log $log): Log => $log);
    $params = $session->params();
    $transforms = $session->transforms();
    $calls = [
        static fn () => $publisher->publish('x'),
        static fn () => $queue->take(0.0),
        static fn () => $service->handle(0.0),
        static fn () => $params->yaml(),
        static fn () => $transforms->lookup('a', 'b'),
    ];
    $session->end();
    foreach ($calls as $call) {
        expectFailure(Status::Closed, '', $call);
    }
    expectEqual([], iterator_to_array($queue));
    $service->run();
    $session->close();
    $session->close();
    foreach ($calls as $call) {
        expectFailure(Status::Closed, '', $call);
    }
    foreach ([$publisher, $queue, $service, $params, $transforms] as $handle) {
        $handle->close();
        $handle->close();
    }
    foreach ($calls as $call) {
        expectFailure(Status::Closed, 'closed before', $call);
    }
    expectFailure(Status::Closed, 'Session', static fn () => $session->subscribeRaw('bytes'));
    expect($other->id() !== 0);
}

function SignalHandlerEndsAWait(): void
{
    $session = Session::open();
    $queue = $session->subscribeRaw('bytes');
    $signals = 0;
    pcntl_async_signals(true);
    pcntl_signal(SIGUSR1, static function () use ($session, &$signals): void {
        if (++$signals === 3) {
            $session->end();
        }
    });
    $sender = new Program('sh', '-c', 'while kill -USR1 ' . getmypid() . '; do sleep 0.05; done');
    try {
        expectFailure(Status::Closed, '', static fn () => $queue->take());
    } finally {
        pcntl_signal(SIGUSR1, SIG_IGN); // Other tests wait without it.
    }
    expect($signals >= 3, $signals);
}

function StreamsWakeAnEventLoop(): void
{
    [$from, $to] = pair();
    $queue = $to->subscribe('words', Log::class, keepAll: 10);
    $service = $to->serve('ask', Log::class, Log::class, static fn (Log $log): Log => text("re: {$log->getMessage()}"));
    [$words, $requests] = [$queue->stream(), $service->stream()];
    $select = static function (int $seconds) use ($words, $requests): array {
        $read = ['words' => $words, 'requests' => $requests];
        [$write, $except] = [null, null];
        stream_select($read, $write, $except, $seconds);
        return array_keys($read);
    };
    expectEqual([], $select(0));
    $publisher = $from->advertise('words', Log::class);
    $from->waitForSubscribers('words', 1, PATIENCE);
    $publisher->publish(text('1'));
    $publisher->publish(text('2'));
    expectEqual(['words'], $select((int) PATIENCE));
    expectEqual('1', $queue->take(0.0)?->getMessage());
    expectEqual(['words'], $select((int) PATIENCE));
    expectEqual('2', $queue->take(0.0)?->getMessage());
    expectEqual([], $select(0));
    $caller = Program::peer('call', 'ask', 'hello');
    expectEqual(['requests'], $select((int) PATIENCE));
    expectEqual(true, $service->handle(0.0));
    expectEqual([], $select(0));
    expectEqual('answer re: hello', $caller->line());
    $caller->finish();
    $to->end();
    expectEqual(['words', 'requests'], $select((int) PATIENCE));
}

function ForkedChildLeavesTheSessionToItsParent(): void
{
    [$from, $to] = pair();
    $queue = $to->subscribe('words', Log::class);
    $publisher = $from->advertise('words', Log::class);
    $from->waitForSubscribers('words', 1, PATIENCE);
    $child = pcntl_fork();
    if ($child === 0) {
        expectFailure(Status::Closed, '', static fn () => $publisher->publish(text('of the child')));
        expectFailure(Status::Closed, '', static fn () => $queue->take(0.0));
        exit(0); // Closes all that it has inherited.
    }
    pcntl_waitpid($child, $status);
    expectEqual(0, pcntl_wexitstatus($status));
    $publisher->publish(text('of the parent'));
    expectEqual('of the parent', $queue->take(PATIENCE)?->getMessage());
}

function ParametersAreDeclaredAndSet(): void
{
    $file = tempnam(sys_get_temp_dir(), 'hgros');
    file_put_contents($file, "wheel: {radius: 0.25}\n");
    try {
        $params = Session::open()->params($file);
        $params->declare('wheel.radius', 0.1, description: 'Of the wheel', unit: 'm', most: 1.0);
        $params->declare('wheel.count', 4);
        $params->declare('name', "it's: \"mine\" / ü");
        $params->declare('gains', [1, 2.5], least: 0.0);
        $params->declare('on', true, readOnly: true);
        $params->declare('mode', 'slow', choices: ['slow', 'fast']);
        expectEqual([0.25, 4, "it's: \"mine\" / ü", '[1.0, 2.5]', true], [$params->number('wheel.radius'),
            $params->integer('wheel.count'), $params->text('name'), $params->yaml('gains'), $params->bool('on')]);
        $params->set('wheel.radius', 0.5);
        $params->set('gains', [3.0, 4.0]);
        $params->set('mode', 'fast');
        $params->setYaml('wheel', '{radius: 0.75, count: 6}');
        expectEqual([0.75, 6, '[3.0, 4.0]', 'fast'], [$params->number('wheel.radius'), $params->integer('wheel.count'),
            $params->yaml('gains'), $params->text('mode')]);
        expectFailure(Status::Refused, '1', static fn () => $params->set('wheel.radius', 2.0));
        expectFailure(Status::Refused, 'fast', static fn () => $params->set('mode', 'fat'));
        expectFailure(Status::Refused, '', static fn () => $params->set('on', false));
        expectFailure(Status::Refused, 'none', static fn () => $params->bool('none'));
        expectFailure(Status::InvalidArgument, '', static fn () => $params->set('gains', [NAN]));
        $params->remove('wheel.count');
        expectEqual(4, $params->integer('wheel.count'));
        $params->save();
        expect(str_contains(file_get_contents($file), 'fast'));
    } finally {
        unlink($file);
    }
}

function ParametersOfAnotherSession(): void
{
    $robot = Session::open('', 'robot');
    $tool = Session::open();
    $own = $robot->params();
    $own->declare('speed', 1);
    $theirs = $tool->paramsOf('robot', PATIENCE);
    awaitUntil('the parameter can be set', static function () use ($theirs): bool {
        try {
            $theirs->set('speed', 7);
            return true;
        } catch (Hgros\HgrosException) {
            return false;
        }
    });
    expectEqual(7, $own->integer('speed'));
}

function TransformsAreFoundByName(): void
{
    [$robot, $tool] = pair();
    [$sent, $seen] = [$robot->transforms(), $tool->transforms()];
    $sent->setStatic('map', 'base', new Transform([1.0, 2.0, 3.0]));
    $found = $seen->wait('map', 'base', 0, PATIENCE);
    expectEqual([[1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0]], [$found->translation, $found->rotation]);
    $now = $robot->now();
    $sent->set('base', 'arm', new Transform([0.0, 0.0, 1.0], stamp: $now));
    $found = $sent->lookup('map', 'arm', $now);
    expectEqual([[1.0, 2.0, 4.0], $now], [$found->translation, $found->stamp]);
    awaitUntil('the other session sees a frame that moves', static function () use ($robot, $sent, $seen): bool {
        $sent->set('base', 'arm', new Transform([0.0, 0.0, 1.0], stamp: $robot->now()));
        try {
            return $seen->lookup('map', 'arm')->translation === [1.0, 2.0, 4.0];
        } catch (Hgros\HgrosException) { // Not yet.
            return false;
        }
    });
    expectFailure(Status::UnknownFrame, 'moon', static fn () => $sent->lookup('map', 'moon'));
    expectFailure(Status::TimedOut, 'moon', static fn () => $seen->wait('map', 'moon', 0, 0.02));
    expectFailure(Status::InvalidArgument, '3 numbers', static fn () => $sent->setStatic('a', 'b', new Transform([])));
    expectFailure(Status::Error, '', static fn () => $robot->transforms());
}

function PeersAndChannelsAreSeen(): void
{
    [$here, $there] = pair();
    $queue = $here->subscribe('words', Log::class);
    $publisher = $there->advertise('words', Log::class);
    $here->waitForPublishers('words', 1, PATIENCE);
    [$peer] = $here->peers();
    expectEqual([$there->id(), getmypid()], [$peer->id, $peer->pid]);
    // A pair that has no shared memory within two seconds begins with ZeroMQ, and moves later.
    awaitUntil('shared memory is used', static fn (): bool => $here->peers()[0]->transport === 'shared memory');
    awaitUntil('the channel is known', static function () use ($here): bool {
        foreach ($here->channels() as $channel) {
            if ($channel->name === 'words' && $channel->typeName === 'foxglove.Log' && $channel->publishers === 1) {
                return $channel->subscribers === 1 && $channel->encoding === Hgros\Encoding::Protobuf;
            }
        }
        return false;
    });
}

function CallsGetRepliesAndFailures(): void
{
    $server = Program::peer('serve', 'ask');
    expectEqual('serving', $server->line());
    $session = Session::open();
    $call = static fn (string $text, string $reply = Log::class)
        => $session->call('ask', text($text), $reply, PATIENCE);
    expectEqual('re: hello', $call('hello')->getMessage());
    expectFailure(Status::HandlerFailed, 'asked to fail', static fn () => $call('fail'));
    expectFailure(Status::TypeMismatch, 'foxglove.PoseInFrame', static fn () => $call('hello', PoseInFrame::class));
    expectFailure(Status::NoServer, 'nobody', static fn () => $session->call('nobody', text(''), Log::class, PATIENCE));
    $server->finish();
}

function CallTimesOutWhileNobodyHandlesIt(): void
{
    [$from, $to] = pair();
    $service = $to->serve('ask', Log::class, Log::class, static fn (Log $log): Log => $log);
    awaitUntil('the server is found, and the call times out', static function () use ($from): bool {
        try {
            $from->call('ask', text('x'), Log::class, 0.1);
        } catch (Hgros\HgrosException $failure) {
            return $failure->status === Status::TimedOut;
        }
        throw new RuntimeException('Somebody has replied.');
    });
    $service->close();
    $service = $to->serve('ask', Log::class, Log::class, static fn (Log $log): Log => $log);
    expectEqual(false, $service->handle(0.0));
}

function HandlerRunsInsideHandleAndItsFailuresReachTheCaller(): void
{
    $session = Session::open();
    $handler = static fn (Log $log): mixed => match ($log->getMessage()) {
        'throw' => throw new RuntimeException('I have no voice'),
        'error' => intdiv(1, 0),
        'type' => 'a string',
        default => text("re: {$log->getMessage()}"),
    };
    $service = $session->serve('ask', Log::class, Log::class, $handler);
    $expected = ['hello' => 'answer re: hello', 'throw' => 'failed I have no voice',
        'error' => 'failed Division by zero', 'type' => 'failed The handler has returned string, but must return '
        . 'Foxglove\Log.', 'again' => 'answer re: again'];
    foreach ($expected as $asked => $answer) {
        $caller = Program::peer('call', 'ask', $asked);
        expectEqual(true, $service->handle(PATIENCE));
        expectEqual($answer, $caller->line());
        $caller->finish();
    }
    expectEqual(3, $service->failed());
}

function ServiceEndsWhileItHandles(): void
{
    $session = Session::open();
    $service = null;
    $service = $session->serve('ask', Log::class, Log::class, static function (Log $log) use (&$service): Log {
        $service->close();
        return $log;
    });
    $caller = Program::peer('call', 'ask', 'hello');
    expectEqual(true, $service->handle(PATIENCE));
    expect(preg_match('/^failed .*(has ended|ended service)/', $caller->line()) === 1);
    expectFailure(Status::Closed, 'closed before', static fn () => $service->handle(0.0));
}

<?php

declare(strict_types=1);

use Foxglove\Log;
use Foxglove\PoseInFrame;
use Hgros\Session;
use Hgros\Status;

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

<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/** Offers a service until it is closed or forgotten. PHP runs the handler inside handle() and run(). */
final class Service extends Handle
{
    private readonly Session $session; // Not forgotten while it is served.
    private readonly \Closure $handler;
    private int $failed = 0;

    /**
     * Session::serve() makes it.
     *
     * @param class-string<\Google\Protobuf\Internal\Message> $request
     * @param class-string<\Google\Protobuf\Internal\Message> $reply
     */
    public function __construct(Session $session, string $name, private readonly string $request,
        private readonly string $reply, callable $handler, int $mostWaiting)
    {
        $options = Library::struct('hgros_serve_options', ['most_waiting' => $mostWaiting]);
        parent::__construct(Library::create('hgros_service', static fn (CData $place): int
            => Library::c()->hgros_serve_queue($session->c(), Library::uncut($name), Schema::of($request)->c(),
                Schema::of($reply)->c(), FFI::addr($options), $place)));
        $this->session = $session;
        $this->handler = $handler(...);
    }

    protected function free(CData $handle): void
    {
        Library::c()->hgros_service_close($handle);
    }

    /** Waits for a request and handles it. False if none came in time; Closed once the session has ended. */
    public function handle(?float $timeout = null): bool
    {
        $service = $this->opened();
        $taken = $this->tryTake() ?? ($timeout === 0.0 ? null
            : Library::await(Library::c()->hgros_service_descriptor($service), $timeout, $this->tryTake(...)));
        if ($taken === null) {
            return false;
        }
        [$request, $place] = $taken;
        try {
            $this->answer(new Message($request), $place);
        } finally {
            Library::c()->hgros_reply_free($place);
        }
        return true;
    }

    /** Handles requests until the session or the service ends. */
    public function run(): void
    {
        try {
            while (true) {
                $this->handle();
            }
        } catch (HgrosException $end) {
            if ($end->status !== Status::Closed) {
                throw $end;
            }
        }
    }

    /** The requests whose handler has thrown. */
    public function failed(): int
    {
        return $this->failed;
    }

    /**
     * A stream that is readable while a request waits, for stream_select() and event loops: then handle(0.0). Neither
     * read nor write it. Only in the command line's PHP.
     *
     * @return resource
     */
    public function stream(): mixed
    {
        return Library::stream(Library::c()->hgros_service_descriptor($this->opened()));
    }

    /** @return ?array{CData, CData} A request and the place for its reply. */
    private function tryTake(): ?array
    {
        $c = Library::c();
        $request = $c->new('hgros_message*');
        $place = $c->new('hgros_reply*');
        $status = $c->hgros_service_take($this->opened(), 0, FFI::addr($request), FFI::addr($place));
        if ($status === Status::TimedOut->value) {
            return null;
        }
        Library::check($status);
        return [$request, $place];
    }

    private function answer(Message $request, CData $place): void
    {
        $status = null;
        try {
            $reply = ($this->handler)($request->read($this->request));
            if (!$reply instanceof $this->reply) {
                throw new \UnexpectedValueException('The handler has returned ' . get_debug_type($reply)
                    . ", but must return {$this->reply}.");
            }
            $bytes = Protobuf::write($reply);
        } catch (\Throwable $error) {
            ++$this->failed;
            $status = Library::c()->hgros_reply_fail($place,
                str_replace("\0", '\0', $error->getMessage()) ?: $error::class);
        }
        $status ??= Library::c()->hgros_reply_set($place, $bytes, strlen($bytes));
        if ($status !== Status::Closed->value) { // Then the caller has been told that the service has ended.
            Library::check($status);
        }
    }
}

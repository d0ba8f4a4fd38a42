<?php

declare(strict_types=1);

namespace Hgros;

use FFI\CData;

/** One participant of the hypergraph. Timeouts are in seconds; null waits for ever. */
final class Session extends Handle
{
    private const FATAL = E_ERROR | E_CORE_ERROR | E_COMPILE_ERROR | E_USER_ERROR | E_RECOVERABLE_ERROR;

    /** @var \WeakMap<self, true>|null Those that were not forgotten. */
    private static ?\WeakMap $all = null;

    /** Opens a session with YAML text; none is the default, which finds the sessions of this user on this host. */
    public static function open(string $yaml = '', string $name = ''): self
    {
        return self::openWith($name, static fn (CData $options, CData $place): int
            => Library::c()->hgros_session_open(Library::uncut($yaml), $options, $place));
    }

    /**
     * Opens a session with configuration files, which are merged.
     *
     * @param list<string> $files
     */
    public static function openFiles(array $files, string $name = ''): self
    {
        return self::openWith($name, static fn (CData $options, CData $place): int => Library::withTexts($files,
            static fn (?CData $list): int
                => Library::c()->hgros_session_open_files($list, count($files), $options, $place)));
    }

    private static function openWith(string $name, callable $open): self
    {
        $text = Library::text($name);
        $options = Library::struct('hgros_session_options', ['name' => $text]);
        $session = new self(Library::create('hgros_session',
            static fn (CData $place): int => $open(\FFI::addr($options), $place)));
        self::$all ??= self::closeAllAfterFatalErrors();
        self::$all[$session] = true;
        return $session;
    }

    /** PHP calls no destructor after a fatal error, and the process of a web server goes on. */
    private static function closeAllAfterFatalErrors(): \WeakMap
    {
        register_shutdown_function(static function (): void {
            if (((error_get_last()['type'] ?? 0) & self::FATAL) !== 0) {
                foreach (self::$all as $session => $true) {
                    $session->close();
                }
            }
        });
        return new \WeakMap();
    }

    protected function free(CData $handle): void
    {
        Library::c()->hgros_session_close($handle);
    }

    /** For the classes here. */
    public function c(): CData
    {
        return $this->opened();
    }

    /**
     * Everything that waits for the session, and every later call, throws Closed. It does not wait. A handler of a
     * signal may call it.
     */
    public function end(): void
    {
        Library::c()->hgros_session_end($this->opened());
    }

    /** The session's id, as MessageInfo has it. Large ones are negative in PHP. */
    public function id(): int
    {
        return Library::c()->hgros_session_id($this->opened());
    }

    public function name(): string
    {
        return Library::c()->hgros_session_name($this->opened());
    }

    /** The session's clock in ns. */
    public function now(): int
    {
        return Library::c()->hgros_session_now($this->opened());
    }

    /** Writes a line into the session's log, which goes to standard error. */
    public function log(LogLevel $level, string $line): void
    {
        Library::check(Library::c()->hgros_session_log($this->opened(), $level->value, Library::uncut($line)));
    }

    /** Lines below this level are not written from now on. */
    public function setLogLevel(LogLevel $level): void
    {
        Library::check(Library::c()->hgros_session_set_log_level($this->opened(), $level->value));
    }

    /** Waits until a channel that this session publishes has subscribers. */
    public function waitForSubscribers(string $channel, int $count = 1, ?float $timeout = null): void
    {
        Library::check(Library::c()->hgros_session_wait_for_subscribers($this->opened(),
            Library::uncut($channel), Library::count($count), Library::nanoseconds($timeout)));
    }

    /** Waits until other sessions that publish on a channel are connected. */
    public function waitForPublishers(string $channel, int $count = 1, ?float $timeout = null): void
    {
        Library::check(Library::c()->hgros_session_wait_for_publishers($this->opened(),
            Library::uncut($channel), Library::count($count), Library::nanoseconds($timeout)));
    }

    /**
     * Announces a channel of a protobuf class.
     *
     * @param class-string<\Google\Protobuf\Internal\Message> $class
     * @param int $latched Number of recent messages kept for late subscribers.
     */
    public function advertise(string $channel, string $class, int $latched = 0): Publisher
    {
        return new Publisher($this->advertiseRaw($channel, Schema::of($class), $latched), $class);
    }

    /** Announces a channel whose messages are bytes of a type. */
    public function advertiseRaw(string $channel, Schema $schema, int $latched = 0): RawPublisher
    {
        return new RawPublisher($this, $channel, $schema, $latched);
    }

    /**
     * Receives a channel of a protobuf class. Messages of another type are counted, not delivered.
     *
     * @param class-string<\Google\Protobuf\Internal\Message> $class
     * @param int $keepLast The newest messages wait, older ones are dropped and counted; 0: 16.
     * @param int $keepAll Not 0: lossless, with room for this many. Publishers get Full meanwhile.
     * @param int $keepAllBytes For $keepAll: also at most about this many bytes.
     */
    public function subscribe(string $channel, string $class, int $keepLast = 0, int $keepAll = 0,
        int $keepAllBytes = 0, string $name = ''): Subscription
    {
        $raw = $this->subscribeRaw($channel, Schema::of($class), $keepLast, $keepAll, $keepAllBytes, $name);
        return new Subscription($raw, $class);
    }

    /** The same for bytes, of one type or of any. */
    public function subscribeRaw(string $channel, ?Schema $schema = null, int $keepLast = 0, int $keepAll = 0,
        int $keepAllBytes = 0, string $name = ''): RawSubscription
    {
        return new RawSubscription($this, $channel, $schema, $keepLast, $keepAll, $keepAllBytes, $name);
    }

    /**
     * Offers a service. Its requests wait until Service::handle() or run() is called.
     *
     * @template Q of \Google\Protobuf\Internal\Message
     * @template R of \Google\Protobuf\Internal\Message
     * @param class-string<Q> $request
     * @param class-string<R> $reply
     * @param callable(Q): R $handler What it throws is the caller's failure, with the same sentence.
     * @param int $mostWaiting Requests that may wait; further ones fail with Full. 0: 16384.
     */
    public function serve(string $name, string $request, string $reply, callable $handler,
        int $mostWaiting = 0): Service
    {
        return new Service($this, $name, $request, $reply, $handler, $mostWaiting);
    }

    /**
     * Calls a service and waits for its reply. Do not call a service that this program serves itself: it would wait for
     * itself.
     *
     * @template R of \Google\Protobuf\Internal\Message
     * @param class-string<R> $reply
     * @return R
     */
    public function call(string $name, \Google\Protobuf\Internal\Message $request, string $reply,
        ?float $timeout = null): \Google\Protobuf\Internal\Message
    {
        $bytes = Protobuf::write($request);
        $message = new Message(Library::create('hgros_message', fn (CData $place): int
            => Library::c()->hgros_call($this->opened(), Library::uncut($name), Schema::of($request::class)->c(),
                $bytes, strlen($bytes), Schema::of($reply)->c(), Library::nanoseconds($timeout), $place)));
        return $message->read($reply);
    }

    /** The parameters of this program, from YAML files. Others may read and set them under the session's name. */
    public function params(string ...$files): Params
    {
        return new Params($this, Library::withTexts($files, fn (?CData $list): CData => Library::create('hgros_params',
            fn (CData $place): int
                => Library::c()->hgros_params_open($this->opened(), $list, count($files), $place))));
    }

    /** The parameters that a session offers under its name. Each function asks it, and waits at most the timeout. */
    public function paramsOf(string $name, float $timeout = 5.0): Params
    {
        return new Params($this, Library::create('hgros_params', fn (CData $place): int
            => Library::c()->hgros_params_of($this->opened(), Library::uncut($name), Library::nanoseconds($timeout),
                $place)));
    }

    /** The session's transforms, which it has once at a time. */
    public function transforms(): Transforms
    {
        return new Transforms($this);
    }

    /** @return list<Peer> The sessions that are connected, at one moment. */
    public function peers(): array
    {
        return Peer::all($this);
    }

    /** @return list<Channel> Those of all sessions that are known, including the own, by name, at one moment. */
    public function channels(): array
    {
        return Channel::all($this);
    }
}

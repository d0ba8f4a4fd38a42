<?php
// The peer in PHP. ../README.md says what each role does.

declare(strict_types=1);

use Foxglove\Log;
use Foxglove\PointCloud;
use Foxglove\PoseInFrame;
use Hgros\HgrosException;
use Hgros\Session;
use Hgros\Status;

const PATIENCE = 30.0; // seconds
const SLICE = 0.1;
const ROOM = 100;

function say(string $line): void
{
    fwrite(STDOUT, "$line\n");
}

/** The bytes of a cloud. */
function pattern(int $size): string
{
    $period = implode('', array_map(static fn (int $i): string => chr($i * 7 + 3 & 255), range(0, 255)));
    return substr(str_repeat($period, intdiv($size, 256) + 1), 0, $size);
}

/** The lines of standard input, which is read without a buffer so that streams can be waited for together. */
final class Input
{
    private string $text = '';
    private bool $ended = false;

    /** Whether there is a next line, or the end, within the timeout; without one it waits for that. */
    public function waits(?float $timeout = null): bool
    {
        return $this->waitsBeside(null, $timeout);
    }

    /** The same, but it also ends with false when another stream is readable. */
    public function waitsBeside(mixed $other, ?float $timeout = null): bool
    {
        while (!$this->ended && !str_contains($this->text, "\n")) {
            $read = array_filter([STDIN, $other]);
            [$write, $except] = [null, null];
            stream_select($read, $write, $except, $timeout === null ? null : (int) $timeout,
                $timeout === null ? null : (int) (fmod($timeout, 1.0) * 1e6));
            if (!in_array(STDIN, $read, true)) {
                return false;
            }
            $part = fread(STDIN, 4096);
            $this->text .= $part;
            $this->ended = $part === '';
        }
        return true;
    }

    public function next(): ?string
    {
        $this->waits();
        $end = strpos($this->text, "\n");
        if ($end === false) {
            return null;
        }
        $line = substr($this->text, 0, $end);
        $this->text = substr($this->text, $end + 1);
        return $line;
    }
}

final class Peer
{
    private readonly Input $input;

    public function __construct(private readonly Session $session)
    {
        stream_set_read_buffer(STDIN, 0);
        $this->input = new Input();
    }

    public function run(string $role, string ...$arguments): void
    {
        $roles = ['talk', 'publish', 'subscribe', 'latch', 'bulk-publish', 'bulk-subscribe', 'serve', 'call', 'misfit'];
        if (!in_array($role, $roles, true)) {
            throw new RuntimeException("There is no role $role.");
        }
        [$this, lcfirst(str_replace('-', '', ucwords($role, '-')))](...$arguments);
    }

    private function talk(): void
    {
        say('ready');
        while (($line = $this->input->next()) !== null) {
            if (trim($line) !== '') {
                $this->run(...preg_split('/ +/', trim($line)));
            }
        }
    }

    private function publish(string $channel, string $count): void
    {
        $publisher = $this->session->advertise($channel, Log::class);
        $this->session->waitForSubscribers($channel, 1, PATIENCE);
        for ($sent = 0; $sent < (int) $count && !$this->input->waits(0.0);) {
            try {
                $publisher->publishWait(new Log(['message' => (string) ($sent + 1)]), SLICE);
            } catch (HgrosException $full) {
                if ($full->status !== Status::TimedOut) {
                    throw $full;
                }
                continue;
            }
            if (++$sent === 1) {
                say('publishing');
            }
        }
        say("published $sent");
        $this->input->waits();
    }

    private function subscribe(string $channel, string $count): void
    {
        $queue = $this->session->subscribe($channel, Log::class, keepAll: ROOM);
        [$stream, $received, $first, $last] = [$queue->stream(), 0, null, null];
        while ($received < (int) $count && !$this->input->waitsBeside($stream)) {
            while ($received < (int) $count && ($log = $queue->take(0.0)) !== null) {
                $last = $log->getMessage();
                if (++$received === 1) {
                    $first = $last;
                    say("receiving $last");
                }
                if ($first === '1' && $last !== (string) $received) {
                    throw new RuntimeException("\"$last\" came, not $received.");
                }
            }
        }
        say("received $received $last");
    }

    private function latch(string $channel, string $text): void
    {
        $publisher = $this->session->advertise($channel, Log::class, latched: 2);
        foreach (['old', $text, 'new'] as $one) {
            $publisher->publish(new Log(['message' => $one]));
        }
        say('latched');
        $this->input->waits();
    }

    private function bulkPublish(string $channel, string $size): void
    {
        $publisher = $this->session->advertise($channel, PointCloud::class);
        $this->session->waitForSubscribers($channel, 1, PATIENCE);
        $cloud = new PointCloud(['point_stride' => 1, 'data' => pattern((int) $size)]);
        $publisher->publishWait($cloud, PATIENCE);
        say("published $size");
        $this->input->waits();
    }

    private function bulkSubscribe(string $channel, string $size): void
    {
        $queue = $this->session->subscribe($channel, PointCloud::class, keepAll: ROOM);
        say('subscribed');
        $data = $queue->take(PATIENCE)?->getData() ?? throw new RuntimeException("Nothing came on $channel.");
        if ($data !== pattern((int) $size)) {
            throw new RuntimeException('The cloud has ' . strlen($data) . ' bytes, or other ones.');
        }
        say("received $size");
    }

    private function serve(string $name): void
    {
        $service = $this->session->serve($name, Log::class, Log::class, static function (Log $request): Log {
            if ($request->getMessage() === 'fail') {
                throw new RuntimeException('asked to fail');
            }
            return new Log(['message' => "re: {$request->getMessage()}"]);
        });
        say('serving');
        $stream = $service->stream();
        while (!$this->input->waitsBeside($stream)) {
            $service->handle(0.0);
        }
        $service->close();
    }

    private function call(string $name, string $text): void
    {
        $end = hrtime(true) + PATIENCE * 1e9;
        while (true) {
            try {
                $answer = $this->session->call($name, new Log(['message' => $text]), Log::class, PATIENCE);
                say("answer {$answer->getMessage()}");
                return;
            } catch (HgrosException $failure) {
                if ($failure->status !== Status::NoServer || hrtime(true) > $end) {
                    say("failed {$failure->getMessage()}");
                    return;
                }
            }
            if ($this->input->waits(0.01)) {
                throw new RuntimeException("Nobody serves $name.");
            }
        }
    }

    private function misfit(string $channel): void
    {
        $queue = $this->session->subscribe($channel, PoseInFrame::class);
        say('subscribed');
        $this->input->waits();
        $queue->close();
    }
}

try {
    (new Peer(Session::open(getenv('HGROS_INTEROP_YAML') ?: '')))->run(...array_slice($argv, 1));
} catch (Throwable $fault) {
    fwrite(STDERR, "peer: {$fault->getMessage()}\n");
    exit(1);
}

<?php
// Runs the tests of a file: run.php FILE [NAME]. They are its functions whose names begin with a capital; one throws if it fails.

declare(strict_types=1);

use Hgros\HgrosException;
use Hgros\Session;
use Hgros\Status;

const PATIENCE = 45.0; // seconds

set_error_handler(static function (int $level, string $text, string $file, int $line): bool {
    if ((error_reporting() & $level) === 0) {
        return false;
    }
    throw new ErrorException($text, 0, $level, $file, $line);
});

function expect(bool $holds, mixed ...$shown): void
{
    if (!$holds) {
        throw new RuntimeException('This does not hold: ' . json_encode($shown));
    }
}

function expectEqual(mixed $expected, mixed $got): void
{
    if ($expected !== $got) {
        throw new RuntimeException(var_export($got, true) . ' instead of ' . var_export($expected, true));
    }
}

/** The exception that a call throws, which must have a status, and a part of its sentence. */
function expectFailure(Status $status, string $part, callable $call): void
{
    try {
        $call();
    } catch (HgrosException $failure) {
        expect($failure->status === $status && str_contains($failure->getMessage(), $part), $failure->status,
            $failure->getMessage(), $part);
        return;
    }
    throw new RuntimeException("{$status->name} was not thrown.");
}

function awaitUntil(string $what, callable $holds): void
{
    for ($end = microtime(true) + PATIENCE; !$holds(); usleep(2000)) {
        if (microtime(true) > $end) {
            throw new RuntimeException("In time it did not hold that $what.");
        }
    }
}

function text(string $message): Foxglove\Log
{
    return new Foxglove\Log(['message' => $message]);
}

/** Two sessions of a domain of their own: the second one gets what the first one sends. */
function pair(): array
{
    return [Session::open(), Session::open()];
}

/** Another program in the domain of the test; killed when it is forgotten. */
final class Program
{
    private readonly mixed $process;
    /** @var array<int, resource> */
    private array $pipes = [];

    public function __construct(string ...$command)
    {
        $this->process = proc_open($command, [['pipe', 'r'], ['pipe', 'w'], STDERR], $this->pipes);
    }

    public function __destruct()
    {
        if (is_resource($this->process)) {
            proc_terminate($this->process, SIGKILL);
        }
    }

    public static function peer(string ...$words): self
    {
        return new self(PHP_BINARY, '-d', 'auto_prepend_file=' . ini_get('auto_prepend_file'),
            __DIR__ . '/../interop/php/peer.php', ...$words);
    }

    public function line(): string
    {
        $read = [$this->pipes[1]];
        [$write, $except] = [null, null];
        stream_set_read_buffer($this->pipes[1], 0);
        expect(stream_select($read, $write, $except, (int) PATIENCE) === 1, 'a line of the program');
        return rtrim((string) fgets($this->pipes[1]), "\n");
    }

    /** Closes its input, and waits until it ends well. Returns the rest of its output. */
    public function finish(): string
    {
        fclose($this->pipes[0]);
        $rest = stream_get_contents($this->pipes[1]);
        expectEqual(0, proc_close($this->process));
        return $rest;
    }
}

$own = get_defined_functions()['user'];
require $argv[1];
$process = getmypid();
$failed = $run = 0;
foreach (array_diff(get_defined_functions()['user'], $own) as $test) {
    $name = (new ReflectionFunction($test))->getName(); // With its capitals.
    if (!ctype_upper($name[0]) || $name !== ($argv[2] ?? $name)) {
        continue;
    }
    ++$run;
    putenv("HGROS_DOMAIN=php-$process-" . strtolower($name));
    echo "RUN $name\n";
    try {
        $name();
        echo "PASS $name\n";
    } catch (Throwable $failure) {
        echo "FAIL $name: $failure\n";
        ++$failed;
    }
    if (getmypid() !== $process) {
        exit(1); // The child of a test that has failed.
    }
}
echo "$run run, $failed failed\n";
exit($failed === 0 && $run > 0 ? 0 : 1);

<?php

declare(strict_types=1);

namespace Hgros;

use FFI;
use FFI\CData;

/** A tree of parameters. A path is written like slam.matcher.gains[2]. */
final class Params extends Handle
{
    private readonly Session $session; // Not forgotten while its parameters are used.

    /** Session::params() and Session::paramsOf() make it. */
    public function __construct(Session $session, CData $handle)
    {
        parent::__construct($handle);
        $this->session = $session;
    }

    protected function free(CData $handle): void
    {
        Library::check(Library::c()->hgros_params_close($handle));
    }

    /**
     * Gives a parameter its kind, bounds, and the value that it has if it was never set.
     *
     * @param bool|int|float|string|list<float> $fallback
     * @param bool $readOnly Keeps the value from the start of the program.
     * @param ?float $least A bound of numbers, included; so is $most.
     * @param list<string> $choices For a text.
     */
    public function declare(string $path, bool|int|float|string|array $fallback, string $description = '',
        string $unit = '', bool $readOnly = false, ?float $least = null, ?float $most = null, array $choices = []): void
    {
        if (is_string($fallback)) {
            Library::uncut($fallback);
        }
        $kind = match (true) {
            is_bool($fallback) => Library::c()->HGROS_PARAM_BOOL,
            is_int($fallback) => Library::c()->HGROS_PARAM_INTEGER,
            is_float($fallback) => Library::c()->HGROS_PARAM_NUMBER,
            is_string($fallback) => Library::c()->HGROS_PARAM_TEXT,
            default => Library::c()->HGROS_PARAM_NUMBERS,
        };
        $texts = [Library::text($description), Library::text($unit)];
        $info = Library::struct('hgros_param_info', ['description' => $texts[0], 'unit' => $texts[1],
            'read_only' => (int) $readOnly, 'has_least' => (int) ($least !== null), 'least' => $least ?? 0.0,
            'has_most' => (int) ($most !== null), 'most' => $most ?? 0.0, 'choice_count' => count($choices)]);
        Library::withTexts($choices, function (?CData $list) use ($path, $kind, $fallback, $info): void {
            $info->choices = $list;
            Library::check(Library::c()->hgros_params_declare($this->opened(), Library::uncut($path), $kind,
                self::yamlOf($fallback), FFI::addr($info)));
        });
    }

    public function bool(string $path): bool
    {
        return $this->get('bool', 'int32_t', $path)->cdata !== 0;
    }

    public function integer(string $path): int
    {
        return $this->get('integer', 'int64_t', $path)->cdata;
    }

    public function number(string $path): float
    {
        return $this->get('number', 'double', $path)->cdata;
    }

    public function text(string $path): string
    {
        return Library::taken($this->get('text', 'char*', $path));
    }

    /** Any value as YAML. An empty path is the whole tree. */
    public function yaml(string $path = ''): string
    {
        return Library::taken($this->get('', 'char*', $path));
    }

    private function get(string $kind, string $type, string $path): CData
    {
        $place = Library::c()->new($type);
        $function = $kind === '' ? 'hgros_params_get' : "hgros_params_get_$kind";
        Library::check(Library::c()->$function($this->opened(), Library::uncut($path), FFI::addr($place)));
        return $place;
    }

    /** @param bool|int|float|string|list<float> $value */
    public function set(string $path, bool|int|float|string|array $value): void
    {
        $c = Library::c();
        Library::uncut($path);
        Library::check(match (true) {
            is_bool($value) => $c->hgros_params_set_bool($this->opened(), $path, (int) $value),
            is_int($value) => $c->hgros_params_set_integer($this->opened(), $path, $value),
            is_float($value) => $c->hgros_params_set_number($this->opened(), $path, $value),
            is_string($value) => $c->hgros_params_set_text($this->opened(), $path, Library::uncut($value)),
            default => $c->hgros_params_set($this->opened(), $path, self::yamlOf($value)),
        });
    }

    /** Sets a value as YAML, such as "{x: 1}". */
    public function setYaml(string $path, string $yaml): void
    {
        Library::check(Library::c()->hgros_params_set($this->opened(), Library::uncut($path), Library::uncut($yaml)));
    }

    /** Removes a value; a declared parameter returns to its fallback. */
    public function remove(string $path): void
    {
        Library::check(Library::c()->hgros_params_remove($this->opened(), Library::uncut($path)));
    }

    /** Writes what was set at run time into the files of this program. */
    public function save(): void
    {
        Library::check(Library::c()->hgros_params_save($this->opened()));
    }

    private static function yamlOf(mixed $value): string
    {
        try { // JSON is YAML, too.
            return json_encode($value, JSON_THROW_ON_ERROR | JSON_PRESERVE_ZERO_FRACTION | JSON_UNESCAPED_UNICODE
                | JSON_UNESCAPED_SLASHES);
        } catch (\JsonException $error) {
            throw new HgrosException(Status::InvalidArgument, 'The value cannot be a parameter: '
                . $error->getMessage(), $error);
        }
    }
}

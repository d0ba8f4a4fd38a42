<?php
// Makes from the C headers what PHP needs of them: the declarations for FFI, and the enums.
//
//     php make_interface.php INCLUDE LIBRARY OUTPUT
//
// INCLUDE is the folder of hgros/hgros.h, LIBRARY the path of libhgros_c.so from the folder OUTPUT, or an absolute one.
// Writes OUTPUT/interface.php, and a class for each enum to OUTPUT/src.

declare(strict_types=1);

// Constants of the headers, by their prefix, and the enum of PHP that they become. The others stay constants of FFI.
const ENUMS = [
    'HGROS_ENCODING_' => ['Encoding', 'How the bytes of a type are written.'],
    'HGROS_LOG_' => ['LogLevel', 'The weight of a line of the log.'],
    'HGROS_' => ['Status', 'Why the library has refused something.'],
];

const MADE = "<?php\n// Made from the C headers.\n\n";

/** The headers in the order in which they include each other, each once. */
function headers(string $include, string $name, array &$seen): string
{
    if (isset($seen[$name])) {
        return '';
    }
    $seen[$name] = true;
    $text = '';
    foreach (file("$include/$name") as $line) {
        $text .= preg_match('/^#include "(.*?)"/', $line, $found) ? headers($include, $found[1], $seen) : $line;
    }
    return $text;
}

/** Without what only a compiler reads: comments, and lines of the preprocessor with what is for C++ alone. */
function declarations(string $text): string
{
    $text = preg_replace('/^#ifdef __cplusplus$.*?^#endif$/ms', '', $text);
    $text = preg_replace(['/^#.*$/m', '#//.*$#m', '#/\*.*?\*/#s'], '', $text);
    return trim(preg_replace("/[ \t]*\n\\s*/", "\n", $text)) . "\n";
}

function enumFor(string $name, string $about, string $prefix, string $body): string
{
    $cases = '';
    foreach (explode("\n", $body) as $line) {
        if (preg_match("#^\\s*$prefix(\\w+) = (\\d+),?\\s*(?:///< (.*))?$#", $line, $found) && $found[1] !== 'OK') {
            $case = str_replace('_', '', ucwords(strtolower($found[1]), '_'));
            $cases .= "    case $case = $found[2];" . (isset($found[3]) ? " // $found[3]" : '') . "\n";
        }
    }
    return MADE . "declare(strict_types=1);\n\nnamespace Hgros;\n\n/** $about */\nenum $name: int\n{\n$cases}\n";
}

if ($argc !== 4) {
    fwrite(STDERR, "usage: make_interface.php INCLUDE LIBRARY OUTPUT\n");
    exit(2);
}
[, $include, $library, $output] = $argv;
$seen = [];
$text = headers($include, 'hgros/hgros.h', $seen);
$path = str_starts_with($library, '/') ? var_export($library, true) : "__DIR__ . '/$library'";
@mkdir("$output/src", 0o755, true);
file_put_contents("$output/interface.php", MADE . "return [$path, <<<'C'\n" . declarations($text) . "C];\n");
preg_match_all('/^enum \{\s*?(.*?)\}/ms', $text, $bodies);
foreach ($bodies[1] as $body) {
    preg_match('/HGROS_\w+/', $body, $first);
    $prefix = $first[0] === 'HGROS_OK' ? 'HGROS_' : preg_replace('/[A-Z]+$/', '', $first[0]);
    if (isset(ENUMS[$prefix])) {
        [$name, $about] = ENUMS[$prefix];
        $lines = preg_replace('/,\s*(?=HGROS_)/', ",\n", $body);
        file_put_contents("$output/src/$name.php", enumFor($name, $about, $prefix, $lines));
    }
}

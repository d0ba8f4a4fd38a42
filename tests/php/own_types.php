<?php
// Classes that protoc makes from the files in own: imports, also public ones, nested types, and namespaces of PHP.

declare(strict_types=1);

use Hgros\Encoding;
use Hgros\Schema;
use Hgros\Session;
use Robo\Top\Top;

function makeClasses(): void
{
    $folder = getenv('HGROS_OWN_TYPES');
    spl_autoload_register(static function (string $class) use ($folder): void {
        $file = "$folder/" . strtr($class, '\\', '/') . '.php';
        if (is_file($file)) {
            require $file;
        }
    });
}

function SchemaOfOwnTypeIsThatOfProtoc(): void
{
    makeClasses();
    $set = file_get_contents(getenv('HGROS_OWN_TYPES') . '/own.desc');
    foreach (['my.top.Top' => Top::class, 'my.top.Top.Inner' => Top\Inner::class, 'my.pkg.Mid' => My\Pkg\Mid::class]
        as $name => $class) {
        $made = Schema::of($class);
        expectEqual($name, $made->typeName());
        expectEqual(Schema::create($name, Encoding::Protobuf, 0, $set)->fingerprint(), $made->fingerprint());
    }
}

function MessagesOfOwnTypesArrive(): void
{
    makeClasses();
    $inner = new Top\Inner(['deep' => [new Top\Inner\Deep(['x' => -3])]]);
    $sent = new Top(['inners' => ['k' => $inner], 'maybe' => 0.0, 'numbers' => [-1, PHP_INT_MIN, 7], 'kind' => 5,
        'base' => new My\Pkg\Base(['kind' => My\Pkg\Base\Kind::ROUND])]);
    expectEqual(bin2hex($sent->serializeToString()), bin2hex(Hgros\Protobuf::write($sent)));
    $session = Session::open();
    $queue = $session->subscribe('tops', Top::class);
    $session->advertise('tops', Top::class)->publish($sent);
    expectEqual($sent->serializeToJsonString(), $queue->take(PATIENCE)?->serializeToJsonString());
}

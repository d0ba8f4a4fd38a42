<?php

declare(strict_types=1);

use Foxglove\Log;
use Foxglove\PointCloud;
use Foxglove\PoseInFrame;
use Hgros\Encoding;
use Hgros\Message;
use Hgros\Schema;
use Hgros\Session;
use Hgros\Status;
use Robo\Top\Top;

function TypedMessagesGoFromSessionToSession(): void
{
    [$one, $other] = pair();
    foreach (['there' => [$one, $other], 'back' => [$other, $one]] as $channel => [$from, $to]) {
        $queue = $to->subscribe($channel, Log::class, keepAll: 10);
        $publisher = $from->advertise($channel, Log::class);
        $from->waitForSubscribers($channel, 1, PATIENCE);
        expectEqual(null, $queue->take(0.0));
        expectEqual(null, $queue->take(0.01));
        $publisher->publish(text('last'));
        $info = $queue->raw->take(PATIENCE)->info();
        expect($info->remote && $info->publisher === $from->id() && $info->publishTime > 1e18, $info);
    }
}

function AnotherTypeIsNotDelivered(): void
{
    [$from, $to] = pair();
    $wrong = $to->subscribe('words', PoseInFrame::class);
    $right = Session::open()->subscribe('words', Log::class);
    $from->advertise('words', Log::class, latched: 1)->publish(text('x'));
    $message = $right->raw->take(PATIENCE);
    expectEqual(null, $wrong->take(0.1));
    expectFailure(Status::TypeMismatch, 'foxglove.Log', static fn () => $message->read(PoseInFrame::class));
    expectFailure(Status::TypeMismatch, 'foxglove.PoseInFrame', static fn () => $from->advertise('words',
        PoseInFrame::class));
    expectFailure(Status::TypeMismatch, 'PoseInFrame', static fn () => $from->advertise('more', Log::class)
        ->publish(new PoseInFrame()));
}

function SchemasOfClassesAreThoseOfTheLibrary(): void
{
    $messages = dirname(ini_get('auto_prepend_file')) . '/messages';
    $compared = 0;
    foreach (glob("$messages/{Foxglove,Hgros}/*.php", GLOB_BRACE) as $file) {
        $class = basename(dirname($file)) . '\\' . basename($file, '.php');
        if (!is_subclass_of($class, Google\Protobuf\Internal\Message::class)) {
            continue;
        }
        $made = Schema::of($class);
        expectEqual(Encoding::Protobuf, $made->encoding());
        try {
            $known = Schema::named($made->typeName());
        } catch (Hgros\HgrosException) { // A part of another type.
            continue;
        }
        expect($made->fingerprint() === $known->fingerprint() && $made->fingerprint() !== 0, $class);
        ++$compared;
    }
    expect($compared >= 38, $compared);
    expectEqual('google.protobuf.Struct', Schema::of(Google\Protobuf\Struct::class)->typeName());
    expectFailure(Status::NotFound, 'no.Such', static fn () => Schema::named('no.Such'));
    expectFailure(Status::InvalidArgument, 'protoc', static fn () => Schema::of(stdClass::class));
}

function ProtobufIsWrittenAsByItsOwnFunction(): void
{
    $scan = new Foxglove\LaserScan(['start_angle' => -1.5, 'end_angle' => NAN, 'ranges' => [0.0, -1e300, INF],
        'frame_id' => 'l', 'timestamp' => new Google\Protobuf\Timestamp(['seconds' => -1, 'nanos' => 999_999_999])]);
    $struct = new Google\Protobuf\Struct();
    $struct->mergeFromJsonString('{"a": [1, null, "ü", {"b": true}], "": -7}');
    $numbers = new Google\Protobuf\Int64Value(['value' => PHP_INT_MIN]);
    $unsigned = new Google\Protobuf\UInt64Value(['value' => -1]);
    $small = new Google\Protobuf\Int32Value(['value' => -5]);
    $cloud = new PointCloud(['point_stride' => 4294967295, 'data' => "\0\xff" . str_repeat('x', 300),
        'fields' => [new Foxglove\PackedElementField(['name' => 'x', 'offset' => 3])]]);
    $float = new Google\Protobuf\FloatValue(['value' => 0.1]);
    foreach ([$scan, $struct, $numbers, $unsigned, $small, $cloud, $float, text(''), text('text')] as $message) {
        expectEqual(bin2hex($message->serializeToString()), bin2hex(Hgros\Protobuf::write($message)));
    }
}

function RawBytesAreLeases(): void
{
    $session = Session::open();
    $schema = Schema::raw('my.bytes');
    $queue = $session->subscribeRaw('bytes', $schema);
    $publisher = $session->advertiseRaw('bytes', $schema);
    $before = Message::leases();
    $publisher->publish("a\0c");
    $publisher->publish('');
    [$first, $second] = [$queue->take(PATIENCE), $queue->take(PATIENCE)];
    expectEqual($before + 2, Message::leases());
    expectEqual(["a\0c", "\0c", 'a', 3], [$first->data(), $first->data(1), $first->data(0, 1), $first->size()]);
    expectEqual(ord('c'), $first->view()[2]);
    expectEqual(['', '', null, 0], [$second->data(), $first->data(3), $second->view(), $second->size()]);
    expectFailure(Status::InvalidArgument, '3 bytes', static fn () => $first->data(1, 3));
    expectEqual(['my.bytes', Encoding::Custom, ''], [$first->typeName(), $first->schema()->encoding(),
        $first->schema()->descriptorSet()]);
    $first->close();
    $first->close();
    expectEqual($before + 1, Message::leases());
    expectFailure(Status::Closed, 'Message', static fn () => $first->data());
    $second = null;
    expectEqual($before, Message::leases());
}

function TypeComesWithTheChannel(): void
{
    [$from, $to] = pair();
    $from->advertise('things', Log::class, latched: 1)->publish(text('x'));
    $message = $to->subscribeRaw('things')->take(PATIENCE);
    expectEqual('foxglove.Log', $message->typeName());
    $set = new Google\Protobuf\Internal\FileDescriptorSet();
    $set->mergeFromString($message->schema()->descriptorSet());
    expectEqual(['google/protobuf/timestamp.proto', 'foxglove/Log.proto'],
        array_map(static fn ($file) => $file->getName(), iterator_to_array($set->getFile())));
    expectEqual('x', $message->read(Log::class)->getMessage());
}

function QueuesDropOrHoldBack(): void
{
    $session = Session::open();
    $newest = $session->subscribe('newest', Log::class, keepLast: 2);
    $every = $session->subscribe('every', Log::class, keepAll: 2, name: 'all of them');
    $dropping = $session->advertise('newest', Log::class);
    $lossless = $session->advertise('every', Log::class);
    for ($i = 0; $i < 5; ++$i) {
        $dropping->publish(text((string) $i));
    }
    expectEqual(['received' => 5, 'dropped' => 3, 'taken' => 0, 'queued' => 2, 'mismatched' => 0], $newest->stats());
    expectEqual('3', $newest->take(0.0)?->getMessage());
    $lossless->publish(text('1'));
    $lossless->publish(text('2'));
    expectFailure(Status::Full, '', static fn () => $lossless->publish(text('3')));
    expectFailure(Status::TimedOut, '', static fn () => $lossless->publishWait(text('3'), 0.02));
    expectEqual('1', $every->take(0.0)?->getMessage());
    $lossless->publishWait(text('3'), PATIENCE);
}

function LargeMessagesAreLentOrCopied(): void
{
    [$from, $to] = pair();
    $bytes = random_bytes(4_000_000);
    $schema = Schema::raw('blob');
    $queue = $to->subscribeRaw('blobs', $schema, keepAll: 4);
    $publisher = $from->advertiseRaw('blobs', $schema);
    $from->waitForSubscribers('blobs', 1, PATIENCE);
    $publisher->publish($bytes);
    expect($queue->take(PATIENCE)->data() === $bytes);
    $loan = $publisher->loan(strlen($bytes));
    foreach (str_split($bytes, 1_000_000) as $i => $part) {
        $loan->write($part, $i * 1_000_000);
    }
    expectFailure(Status::InvalidArgument, '2 bytes at 3999999', static fn () => $loan->write('xx', 3_999_999));
    $loan->publish(PATIENCE);
    expectFailure(Status::Closed, 'Loan', static fn () => $loan->write('x'));
    expect($queue->take(PATIENCE)->data() === $bytes);
}

/** Classes that protoc makes from the files in own: imports, also public ones, nested types, and namespaces of PHP. */
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

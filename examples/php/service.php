<?php
// Serves the square root of a number: service.php. Calls it from another process: service.php NUMBER.

use Google\Protobuf\DoubleValue;
use Hgros\HgrosException;
use Hgros\Session;

$session = Session::open();
if ($argc > 1) {
    try {
        $number = new DoubleValue(['value' => (float) $argv[1]]);
        $root = $session->call('root', $number, DoubleValue::class, 5.0);
        echo "The root of {$number->getValue()} is {$root->getValue()}\n";
    } catch (HgrosException $failure) {
        echo "{$failure->getMessage()}\n";
    }
    exit;
}
$root = static function (DoubleValue $number): DoubleValue {
    if ($number->getValue() < 0) {
        throw new DomainException('There is no root of a number below zero.');
    }
    return new DoubleValue(['value' => sqrt($number->getValue())]);
};
$session->serve('root', DoubleValue::class, DoubleValue::class, $root)->run();

<?php
// The roles of tests/interop/php/peer.php, each against itself.

declare(strict_types=1);

function MessagesGoFromPeerToPeer(): void
{
    $subscriber = Program::peer('subscribe', 'words', '1000');
    expectEqual('subscribed', $subscriber->line());
    $publisher = Program::peer('publish', 'words', '1000');
    expectEqual('published 1000', $publisher->line());
    expectEqual('received 1000', $subscriber->line());
    $publisher->finish();
    $subscriber->finish();
}

function LatchedMessageGoesFromPeerToPeer(): void
{
    $publisher = Program::peer('latch', 'words', 'kept');
    expectEqual('latched', $publisher->line());
    expectEqual("late kept\n", Program::peer('late', 'words')->finish());
    $publisher->finish();
}

function CloudGoesFromPeerToPeer(): void
{
    $subscriber = Program::peer('bulk-subscribe', 'clouds', '4000000');
    expectEqual('subscribed', $subscriber->line());
    $publisher = Program::peer('bulk-publish', 'clouds', '4000000');
    expectEqual('published 4000000', $publisher->line());
    expectEqual('received 4000000', $subscriber->line());
    $publisher->finish();
    $subscriber->finish();
}

function PeersTellWhichTypesDiffer(): void
{
    $publisher = Program::peer('latch', 'words', 'x');
    expectEqual('latched', $publisher->line());
    $misfit = Program::peer('misfit', 'words');
    expectEqual('subscribed', $misfit->line());
    expectEqual('', $misfit->finish());
    $publisher->finish();
}

function PeersSurviveEachOther(): void
{
    $follower = Program::peer('follow', 'words');
    $publisher = Program::peer('stream', 'words');
    expectEqual('streaming', $publisher->line());
    expectEqual('following', $follower->line());
    $follower = Program::peer('follow', 'words'); // The other one is killed.
    expectEqual('following', $follower->line());
    $publisher = Program::peer('publish', 'words', '10');
    expectEqual('published 10', $publisher->line());
    $publisher->finish();
    expect(preg_match('/^followed [1-9]\d*\n$/', $follower->finish()) === 1);
}

function PeerPlaysOneRoleAfterTheOther(): void
{
    [$one, $other] = [Program::peer('talk'), Program::peer('talk')];
    expectEqual(['ready', 'ready'], [$one->line(), $other->line()]);
    $one->say('serve ask');
    expectEqual('serving', $one->line());
    $other->say('call ask hello');
    expectEqual('answer re: hello', $other->line());
    $one->say('latch words kept');
    expectEqual('latched', $one->line());
    $other->say('late words');
    expectEqual('late kept', $other->line());
}

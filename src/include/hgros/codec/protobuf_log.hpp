#pragma once

namespace hgros {

// protobuf writes a line for each text that is not UTF-8, so any publisher could fill the log of a subscriber. From now
// on the process writes one in 10 s; the session's log names the message. Other lines of protobuf are left alone.
//
// Threading: call it once, before messages are parsed.
void LimitProtobufLog();

}  // namespace hgros

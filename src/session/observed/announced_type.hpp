#pragma once

#include <string>
#include <typeinfo>

#include "hgros/codec/message.hpp"

namespace hgros {

// The announced type of a channel on which every session offers messages about itself. It has no fingerprint: that is
// computed from the schema, and building the schema would cost half a megabyte in a process that nobody observes.
template <class T>
const TypeInfo& AnnouncedTypeOf(const char* name) {
  static const TypeInfo announced = [name] {
    TypeInfo info;
    info.name = name;
    info.encoding = Encoding::kProtobuf;
    info.cpp_type = typeid(T);
    info.descriptor_set = [] { return TypeOf<T>().descriptor_set(); };
    info.descriptor = [] { return TypeOf<T>().descriptor(); };
    return info;
  }();
  return announced;
}

}  // namespace hgros

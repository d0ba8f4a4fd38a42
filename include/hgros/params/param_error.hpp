#pragma once

#include "hgros/base/error.hpp"

namespace hgros {

/// A parameter is missing or has a wrong value. where() is "file:line:column", or the source that set the value.
class HGROS_EXPORT ParamError : public Error {
 public:
  using Error::Error;
};

}  // namespace hgros

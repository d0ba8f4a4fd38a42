#pragma once

#include "hgros/base/error.hpp"

namespace hgros {

/// A parameter is not there or is not what was wanted. where() is "file:line:column", or who said the value.
class HGROS_EXPORT ParamError : public Error {
 public:
  using Error::Error;
};

}  // namespace hgros

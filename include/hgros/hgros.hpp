#pragma once

/// Everything a program needs: Session, and the free functions over a default one.
#include "hgros/base/error.hpp"
#include "hgros/session/default_session.hpp"
#include "hgros/session/session.hpp"

#pragma once

/// The types that parameters can have: numbers, texts, durations and enumerations; optional values, lists and maps of
/// them; structs; vectors and matrices.
#include "hgros/internal/params/param_list_codec.hpp"
#include "hgros/internal/params/param_matrix_codec.hpp"
#include "hgros/internal/params/param_scalar_codec.hpp"
#include "hgros/internal/params/param_struct_codec.hpp"

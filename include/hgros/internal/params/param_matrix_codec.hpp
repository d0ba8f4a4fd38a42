#pragma once

#include <concepts>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "hgros/params/param_view.hpp"

namespace hgros {

namespace params_detail {

/// A dense matrix or vector of Eigen, recognized without including Eigen.
template <class T>
concept DenseMatrix = requires(const T m) {
  typename T::Scalar;
  { int(T::RowsAtCompileTime) } -> std::same_as<int>;
  { int(T::ColsAtCompileTime) } -> std::same_as<int>;
  m(0, 0);
  m.rows();
  m.cols();
};

}  // namespace params_detail

/// Vectors are lists, matrices are lists of rows.
template <params_detail::DenseMatrix T>
struct ParamCodec<T> {
  using Scalar = typename T::Scalar;
  static constexpr int kRows = T::RowsAtCompileTime;
  static constexpr int kCols = T::ColsAtCompileTime;
  static constexpr bool kVector = kRows == 1 || kCols == 1;

  [[nodiscard]] static T Read(const ParamView& view) {
    const std::string wanted = Wanted();
    view.RequireList(wanted);
    const std::size_t height = view.size();
    T matrix;
    if constexpr (kVector) {
      if (!Fits(height, kRows == 1 ? kCols : kRows)) view.FailType(wanted);
      if constexpr (kRows < 0 || kCols < 0) matrix.resize(static_cast<int>(height));
      for (std::size_t i = 0; i < height; ++i) matrix(static_cast<int>(i)) = ParamCodec<Scalar>::Read(view[i]);
    } else {
      const std::size_t width = height == 0 ? 0 : view[0].size();
      if (!Fits(height, kRows) || !Fits(width, kCols)) view.FailType(wanted);
      if constexpr (kRows < 0 || kCols < 0) matrix.resize(static_cast<int>(height), static_cast<int>(width));
      for (std::size_t row = 0; row < height; ++row) {
        const ParamView line = view[row];
        line.RequireList("a list of " + std::to_string(width) + " numbers");
        if (line.size() != width) line.FailType("a list of " + std::to_string(width) + " numbers");
        for (std::size_t col = 0; col < width; ++col) {
          matrix(static_cast<int>(row), static_cast<int>(col)) = ParamCodec<Scalar>::Read(line[col]);
        }
      }
    }
    return matrix;
  }

  [[nodiscard]] static ParamNode Write(const T& matrix) {
    std::vector<ParamNode> rows;
    for (int row = 0; row < matrix.rows(); ++row) {
      std::vector<ParamNode> line;
      for (int col = 0; col < matrix.cols(); ++col) line.push_back(ParamCodec<Scalar>::Write(matrix(row, col)));
      if constexpr (kVector) {
        for (ParamNode& number : line) rows.push_back(std::move(number));
      } else {
        rows.push_back(ParamNode::List(std::move(line)));
      }
    }
    return ParamNode::List(std::move(rows));
  }

 private:
  static constexpr bool Fits(std::size_t size, int fixed) {
    return fixed < 0 || size == static_cast<std::size_t>(fixed);
  }
  static std::string Wanted() {
    const auto count = [](int fixed) { return fixed < 0 ? std::string() : std::to_string(fixed) + " "; };
    if constexpr (kVector) return "a list of " + count(kRows == 1 ? kCols : kRows) + "numbers";
    return "a list of " + count(kRows) + "rows of " + count(kCols) + "numbers";
  }
};

}  // namespace hgros

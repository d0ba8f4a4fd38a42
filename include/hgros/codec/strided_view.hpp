#pragma once

#include <bit>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <utility>

namespace hgros {

/// Little-endian numbers at a distance of `stride_bytes`, such as the x of all points, at any alignment. They are read
/// in place, so a view borrows the message. The creator of a view has checked that all numbers are in memory; the user
/// is responsible for indices.
template <class T>
requires(std::integral<T> || std::floating_point<T>) class StridedView {
  static_assert(std::endian::native == std::endian::little,
                "Packed values are little-endian and are read without conversion.");

 public:
  class Iterator {
   public:
    // NOLINTBEGIN(readability-identifier-naming): as the standard asks for them.
    using value_type = T;
    using difference_type = std::ptrdiff_t;
    using iterator_concept = std::random_access_iterator_tag;
    using iterator_category = std::input_iterator_tag;  // It returns values, not references.
    // NOLINTEND(readability-identifier-naming)

    Iterator() = default;
    Iterator(const StridedView& view, std::ptrdiff_t index)
        : first_(view.first_), stride_(view.stride_), index_(index) {}
    T operator*() const { return ValueAt(first_ + index_ * static_cast<std::ptrdiff_t>(stride_)); }
    T operator[](std::ptrdiff_t n) const { return *(*this + n); }
    Iterator& operator+=(std::ptrdiff_t n) {
      index_ += n;
      return *this;
    }
    Iterator& operator-=(std::ptrdiff_t n) { return *this += -n; }
    Iterator& operator++() { return *this += 1; }
    Iterator& operator--() { return *this += -1; }
    Iterator operator++(int) { return std::exchange(*this, *this + 1); }
    Iterator operator--(int) { return std::exchange(*this, *this - 1); }
    friend Iterator operator+(Iterator at, std::ptrdiff_t n) { return at += n; }
    friend Iterator operator+(std::ptrdiff_t n, Iterator at) { return at += n; }
    friend Iterator operator-(Iterator at, std::ptrdiff_t n) { return at -= n; }
    friend std::ptrdiff_t operator-(const Iterator& a, const Iterator& b) { return a.index_ - b.index_; }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.index_ == b.index_; }
    friend auto operator<=>(const Iterator& a, const Iterator& b) { return a.index_ <=> b.index_; }

   private:
    const std::byte* first_ = nullptr;
    std::size_t stride_ = 0;
    std::ptrdiff_t index_ = 0;
  };

  StridedView() = default;
  StridedView(const std::byte* first, std::size_t stride_bytes, std::size_t count) noexcept
      : first_(first), stride_(stride_bytes), count_(count) {}

  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  [[nodiscard]] std::size_t stride_bytes() const noexcept { return stride_; }
  [[nodiscard]] T operator[](std::size_t index) const noexcept { return ValueAt(first_ + index * stride_); }
  [[nodiscard]] Iterator begin() const noexcept { return {*this, 0}; }
  [[nodiscard]] Iterator end() const noexcept { return {*this, static_cast<std::ptrdiff_t>(count_)}; }

 private:
  [[nodiscard]] static T ValueAt(const std::byte* bytes) noexcept {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }

  const std::byte* first_ = nullptr;
  std::size_t stride_ = 0;
  std::size_t count_ = 0;
};

}  // namespace hgros

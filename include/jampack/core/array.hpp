// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cstddef>
#include <initializer_list>
#include <vector>

namespace jampack {

/// Signed index and count, the same type as Eigen's, so that sizes and loops need no casts.
using Index = std::ptrdiff_t;

/// Contiguous storage with signed size and index; bounds are asserted in debug builds.
template <class T>
class Array : private std::vector<T> {
  using Base = std::vector<T>;

 public:
  using typename Base::const_iterator;
  using typename Base::iterator;
  using typename Base::value_type;

  Array() = default;
  explicit Array(Index n) : Base(static_cast<std::size_t>(n)) {}
  Array(Index n, const T& value) : Base(static_cast<std::size_t>(n), value) {}
  Array(std::initializer_list<T> values) : Base(values) {}
  template <class Iterator>
  requires requires(Iterator i) {
    *i;
    ++i;
  }
  Array(Iterator first, Iterator last) : Base(first, last) {}

  T& operator[](Index i) {
    assert(i >= 0 && i < size());
    return Base::operator[](static_cast<std::size_t>(i));
  }
  const T& operator[](Index i) const {
    assert(i >= 0 && i < size());
    return Base::operator[](static_cast<std::size_t>(i));
  }
  Index size() const { return static_cast<Index>(Base::size()); }
  void resize(Index n) { Base::resize(static_cast<std::size_t>(n)); }
  void resize(Index n, const T& value) { Base::resize(static_cast<std::size_t>(n), value); }
  void assign(Index n, const T& value) { Base::assign(static_cast<std::size_t>(n), value); }
  void reserve(Index n) { Base::reserve(static_cast<std::size_t>(n)); }

  using Base::back;
  using Base::begin;
  using Base::clear;
  using Base::data;
  using Base::emplace_back;
  using Base::empty;
  using Base::end;
  using Base::erase;
  using Base::front;
  using Base::insert;
  using Base::pop_back;
  using Base::push_back;

  friend bool operator==(const Array& a, const Array& b) {
    return static_cast<const Base&>(a) == static_cast<const Base&>(b);
  }
};

}  // namespace jampack

// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <jampack/core/array.hpp>

namespace jampack {

/// A short list of plain values: as many as `Capacity` without an allocation, beyond that all on the heap.
template <class T, Index Capacity>
class InlineArray {
 public:
  using value_type = T;

  void push_back(const T& value) {
    if (size_ < Capacity) {
      few_[std::size_t(size_)] = value;
    } else {
      if (size_ == Capacity) many_ = Array<T>(few_.begin(), few_.end());
      many_.push_back(value);
    }
    ++size_;
  }
  void clear() {
    many_.clear();
    size_ = 0;
  }

  Index size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* data() { return size_ <= Capacity ? few_.data() : many_.data(); }
  const T* data() const { return size_ <= Capacity ? few_.data() : many_.data(); }
  T* begin() { return data(); }
  T* end() { return data() + size_; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  T& operator[](Index i) {
    assert(i >= 0 && i < size_);
    return data()[i];
  }
  const T& operator[](Index i) const {
    assert(i >= 0 && i < size_);
    return data()[i];
  }

 private:
  Index size_ = 0;
  std::array<T, std::size_t(Capacity)> few_{};
  Array<T> many_;
};

}  // namespace jampack

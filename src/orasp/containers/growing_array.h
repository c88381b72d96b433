#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

#include <malloc.h>
#include <sys/mman.h>

namespace orasp::detail {

/// An array of plain values that grows without being zeroed or, for large sizes, copied: realloc
/// moves pages instead of bytes (mremap on Linux). std::vector would touch every byte twice; state
/// tables are hundreds of megabytes.
template <class T>
requires std::is_trivially_copyable_v<T>
class GrowingArray {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] T& operator[](std::size_t i) { return data_.get()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_.get()[i]; }
  [[nodiscard]] T& back() { return data_.get()[size_ - 1]; }
  [[nodiscard]] const T& back() const { return data_.get()[size_ - 1]; }
  [[nodiscard]] std::span<T> span() { return {data(), size_}; }
  [[nodiscard]] std::span<const T> span() const { return {data(), size_}; }
  /// Memory in use; pages reserved beyond it were never touched. A large page is there as a whole.
  [[nodiscard]] std::uint64_t bytes() const {
    const std::uint64_t used = size_ * sizeof(T);
    if (!huge_pages_) return used;
    return std::min<std::uint64_t>((used + kHugePage - 1) / kHugePage * kHugePage,
                                   capacity_ * sizeof(T));
  }

  void push_back(const T& value) {
    if (size_ == capacity_) reserve(capacity_ == 0 ? 64 : capacity_ * 2);
    data_.get()[size_++] = value;
  }
  /// New elements are left as they are: write them before reading them.
  void resize(std::size_t size) {
    if (size > capacity_) reserve(size + size / 2);
    size_ = size;
    if (!huge_pages_ && size * sizeof(T) >= kLarge) ask_for_huge_pages();
  }
  void clear() { size_ = 0; }
  /// Gives memory beyond size() back.
  void shrink_to_fit() {
    if (size_ == 0) {
      data_.reset();
      capacity_ = 0;
    } else if (capacity_ > size_) {
      reallocate(size_);
    }
  }
  void reserve(std::size_t capacity) {
    if (capacity > capacity_) reallocate(capacity);
  }

 private:
  static constexpr std::size_t kLarge = std::size_t{1} << 20U;
  static constexpr std::uint64_t kHugePage = std::uint64_t{2} << 20U;

  // Large tables are touched once from end to end: with pages of 2 MiB the kernel is entered 512
  // times less often. A hint, given once an array is large (a huge page is cleared whole); where it
  // is not taken nothing changes. It goes to the whole mapping, from the page of the allocator's
  // header to its end: given to a part it would cut the mapping in two, which mremap does not move,
  // and realloc would copy, with both copies in memory.
  void ask_for_huge_pages() {
    huge_pages_ = true;
    constexpr std::uintptr_t kPage = 4096;
    const auto data = reinterpret_cast<std::uintptr_t>(data_.get());
    const auto begin = data & ~(kPage - 1);
    const auto end = (data + malloc_usable_size(data_.get())) & ~(kPage - 1);
    if (begin < end)
      static_cast<void>(madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE));
  }

  struct Free {
    void operator()(T* memory) const { std::free(memory); }
  };
  void reallocate(std::size_t capacity) {
    void* moved = std::realloc(static_cast<void*>(data_.get()), capacity * sizeof(T));
    if (moved == nullptr) throw std::bad_alloc();
    static_cast<void>(data_.release());
    data_.reset(static_cast<T*>(moved));
    capacity_ = capacity;
    huge_pages_ = false;
  }

  std::unique_ptr<T, Free> data_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
  bool huge_pages_ = false;
};

}  // namespace orasp::detail

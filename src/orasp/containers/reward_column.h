#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "orasp/containers/growing_array.h"

namespace orasp::detail {

/// Numbers the distinct values of a stream of doubles: the same bits, the same number. One thread's
/// own.
class ValueNumbers {
 public:
  /// Number of `value`, from 0 in order of first appearance.
  [[nodiscard]] std::uint32_t number(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    Recent& recent = recent_[(bits * 0x9e3779b97f4a7c15ULL) >> 56];
    if (recent.bits == bits && recent.number != kEmpty) return recent.number;
    const auto [at, is_new] =
        numbers_.try_emplace(bits, static_cast<std::uint32_t>(values_.size()));
    if (is_new) values_.push_back(value);
    recent = {bits, at->second};
    return at->second;
  }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

 private:
  static constexpr std::uint32_t kEmpty = 0xffffffffU;
  struct Recent {
    std::uint64_t bits = 0;
    std::uint32_t number = kEmpty;
  };
  std::vector<Recent> recent_ = std::vector<Recent>(256);
  std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
  std::vector<double> values_;
};

/// A long column of doubles of which few are different: 1 byte each while at most 256 values occur,
/// 2 bytes up to 65,536, then 8. Objectives that price pieces by size have a handful of rewards
/// over millions of actions.
class RewardColumn {
 public:
  static constexpr std::size_t kMostNumbered = 65'536;

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool numbered() const { return width_ != 8; }
  [[nodiscard]] double operator[](std::size_t i) const {
    switch (width_) {
      case 1: return table_[narrow_[i]];
      case 2: return table_[wide_[i]];
      default: return plain_[i];
    }
  }
  [[nodiscard]] std::uint64_t bytes() const {
    return narrow_.bytes() + wide_.bytes() + plain_.bytes();
  }
  // The arrays themselves: where numbered(), the places in distinct() of all rewards, in one of the
  // first two; else the rewards, in the third. The other two are empty.
  [[nodiscard]] std::span<const std::uint8_t> narrow_numbers() const { return narrow_.span(); }
  [[nodiscard]] std::span<const std::uint16_t> wide_numbers() const { return wide_.span(); }
  [[nodiscard]] std::span<const double> plain_values() const { return plain_.span(); }
  /// Distinct values, while numbered(); after the last, zeros up to 256.
  [[nodiscard]] const std::vector<double>& distinct() const { return table_; }

  /// Makes sure that all of `values` have numbers, widening or giving up numbering where there are
  /// too many. Returns their numbers (meaningless once numbered() is false).
  [[nodiscard]] std::vector<std::uint32_t> admit(const std::vector<double>& values) {
    std::vector<std::uint32_t> numbers;
    if (!numbered()) return numbers;
    for (const double value : values) {
      numbers.push_back(numbers_.number(value));
      if (numbers_.values().size() > kMostNumbered) {
        widen(8);
        return numbers;
      }
    }
    table_ = numbers_.values();
    table_.resize(std::max<std::size_t>(256, table_.size()));  // so that any byte may be looked up
    if (numbers_.values().size() > 256) widen(2);
    return numbers;
  }
  /// Makes room for `count` more; the new ones are written by set_number or set_value.
  void extend(std::size_t count) {
    size_ += count;
    switch (width_) {
      case 1: narrow_.resize(size_); break;
      case 2: wide_.resize(size_); break;
      default: plain_.resize(size_); break;
    }
  }
  /// Address space for `count` in all, at the present width.
  void reserve(std::size_t count) {
    switch (width_) {
      case 1: narrow_.reserve(count); break;
      case 2: wide_.reserve(count); break;
      default: plain_.reserve(count); break;
    }
  }
  void set_number(std::size_t i, std::uint32_t number) {
    if (width_ == 1) {
      narrow_[i] = static_cast<std::uint8_t>(number);
    } else {
      wide_[i] = static_cast<std::uint16_t>(number);
    }
  }
  void set_value(std::size_t i, double value) { plain_[i] = value; }
  void shrink_to_fit() {
    narrow_.shrink_to_fit();
    wide_.shrink_to_fit();
    plain_.shrink_to_fit();
  }

  /// Calls `visit` with the column as something indexable by action at full speed (the width is
  /// looked at once).
  template <class Visit>
  decltype(auto) with_reader(Visit&& visit) const {
    switch (width_) {
      case 1:
        return visit(
            [table = table_.data(), at = narrow_.data()](std::size_t i) { return table[at[i]]; });
      case 2:
        return visit(
            [table = table_.data(), at = wide_.data()](std::size_t i) { return table[at[i]]; });
      default: return visit([at = plain_.data()](std::size_t i) { return at[i]; });
    }
  }

 private:
  void widen(std::size_t width) {
    if (width <= width_) return;
    if (width == 2) {
      wide_.resize(size_);
      for (std::size_t i = 0; i < size_; ++i) wide_[i] = narrow_[i];
    } else {
      plain_.resize(size_);
      for (std::size_t i = 0; i < size_; ++i) plain_[i] = (*this)[i];
      wide_ = {};
    }
    narrow_ = {};
    width_ = width;
  }

  std::size_t width_ = 1;
  std::size_t size_ = 0;
  ValueNumbers numbers_;
  std::vector<double> table_;
  GrowingArray<std::uint8_t> narrow_;
  GrowingArray<std::uint16_t> wide_;
  GrowingArray<double> plain_;
};

}  // namespace orasp::detail

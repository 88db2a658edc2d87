#include "scan/columns.hpp"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

namespace extperfc::scan {

namespace {

constexpr unsigned kDigitBits = 11;
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;

/// One pass of a counting sort, stable: by digit_of(entry), from `from` to `to`.
template <typename Entry, typename DigitOf>
void sort_by_digit(const std::vector<Entry>& from, std::size_t size, DigitOf digit_of,
                   std::vector<Entry>& to) {
  std::array<std::uint32_t, kDigits> places{};
  for (std::size_t i = 0; i < size; ++i) ++places[digit_of(from[i])];
  std::uint32_t start = 0;
  for (std::uint32_t& place : places) start += std::exchange(place, start);
  for (std::size_t i = 0; i < size; ++i) to[places[digit_of(from[i])]++] = from[i];
}

}  // namespace

void Columns::clear(std::size_t rays, std::size_t max_points) {
  size_ = 0;
  if (entries_.size() < max_points) {
    entries_.resize(max_points);
    sorted_.resize(max_points);
  }
  starts_.assign(rays, 0);
  ends_.assign(rays, 0);
}

void Columns::sort() {
  sort_by_range();
  sort_by_ray();
  sort_equals();
}

/// By the 22 highest bits of what is between the shortest and the longest range: 5e-6 of a range or finer,
/// for ranges from 0.1 to 200 m.
void Columns::sort_by_range() {
  const auto [shortest, longest] =
      std::minmax_element(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(size_),
                          [](const Entry& a, const Entry& b) { return a.range_bits < b.range_bits; });
  if (size_ == 0) return;
  const std::uint32_t first = shortest->range_bits;
  unsigned shift = 0;
  while ((longest->range_bits - first) >> shift >= kDigits * kDigits) ++shift;
  sort_by_digit(
      entries_, size_,
      [=](const Entry& entry) { return (entry.range_bits - first) >> shift & (kDigits - 1); }, sorted_);
  sort_by_digit(
      sorted_, size_, [=](const Entry& entry) { return (entry.range_bits - first) >> shift >> kDigitBits; },
      entries_);
}

void Columns::sort_by_ray() {
  for (std::size_t i = 0; i < size_; ++i) ++ends_[entries_[i].ray];
  std::size_t start = 0;
  for (std::size_t ray = 0; ray < starts_.size(); ++ray) {
    starts_[ray] = start;
    start += std::exchange(ends_[ray], start);
  }
  points_.resize(size_);
  for (std::size_t i = 0; i < size_; ++i) {
    ColumnPoint& point = points_[ends_[entries_[i].ray]++];
    std::memcpy(&point.range, &entries_[i].range_bits, sizeof point.range);
    point.index = entries_[i].index;
  }
}

/// Ranges that were one to sort_by_range().
void Columns::sort_equals() {
  const auto before = [](const ColumnPoint& a, const ColumnPoint& b) {
    return std::tie(a.range, a.index) < std::tie(b.range, b.index);
  };
  for (std::size_t ray = 0; ray < starts_.size(); ++ray) {
    const Column all = column(ray);
    if (!std::is_sorted(all.begin(), all.end(), before)) std::sort(all.begin(), all.end(), before);
  }
}

}  // namespace extperfc::scan

#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace extperfc::scan {

/// A point in the column of its ray.
struct ColumnPoint {
  float range{0};          ///< horizontal, from the target frame's origin [m]
  std::uint32_t index{0};  ///< of the point in its cloud
};

/// One ray's points in order of their range.
struct Column {
  ColumnPoint* first{nullptr};
  ColumnPoint* last{nullptr};  ///< behind the last one

  [[nodiscard]] ColumnPoint* begin() const { return first; }
  [[nodiscard]] ColumnPoint* end() const { return last; }
  [[nodiscard]] bool empty() const { return first == last; }
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(last - first); }
};

/// Sorts points into columns: counting sorts by range and then by ray, O(points + rays) but for columns with
/// ranges that are alike to some 5e-6, which are sorted once more. Memory is kept from cloud to cloud.
class Columns {
 public:
  /// Makes room for `max_points`.
  void clear(std::size_t rays, std::size_t max_points);
  /// The range must not be negative. Points come in the order of their indices, which is kept among equal
  /// ranges.
  void add(std::size_t ray, float range, std::size_t index) {
    Entry& entry = entries_[size_++];
    std::memcpy(&entry.range_bits, &range, sizeof range);
    entry.index = static_cast<std::uint32_t>(index);
    entry.ray = static_cast<std::uint32_t>(ray);
  }
  void sort();

  /// Valid after sort(). Points of a column may be dropped by shrink().
  [[nodiscard]] Column column(std::size_t ray) {
    return {points_.data() + starts_[ray], points_.data() + ends_[ray]};
  }
  /// Only the first `size` points of a column remain.
  void shrink(std::size_t ray, std::size_t size) { ends_[ray] = starts_[ray] + size; }

 private:
  struct Entry {
    std::uint32_t range_bits;  ///< of a float: in the order of ranges
    std::uint32_t index;
    std::uint32_t ray;
  };

  void sort_by_range();
  void sort_by_ray();
  void sort_equals();

  std::vector<Entry> entries_, sorted_;  ///< the first size_ of them count
  std::size_t size_{0};
  std::vector<std::size_t> starts_, ends_;
  std::vector<ColumnPoint> points_;
};

}  // namespace extperfc::scan

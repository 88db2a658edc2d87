#pragma once

#include <cstddef>
#include <cstdint>
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

/// Sorts points into columns: a counting sort by ray, then each column by range. Memory is kept from cloud to
/// cloud.
class Columns {
 public:
  void clear(std::size_t rays);
  /// The range must not be negative.
  void add(std::size_t ray, float range, std::size_t index);
  void sort();

  /// Valid after sort(). Points of a column may be dropped by shrink().
  [[nodiscard]] Column column(std::size_t ray);
  /// Only the first `size` points of a column remain.
  void shrink(std::size_t ray, std::size_t size) { ends_[ray] = starts_[ray] + size; }

 private:
  struct Waiting {
    std::uint32_t ray;
    std::uint64_t key;  ///< the range's bits, which are in the order of ranges, before the index
  };
  std::vector<Waiting> waiting_;
  std::vector<std::size_t> starts_, ends_;
  std::vector<std::uint64_t> keys_;
  std::vector<ColumnPoint> points_;
};

}  // namespace extperfc::scan

#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc::mapping {

/// A grid with copy-on-write: it is changed in place while no reader holds it, else copied first. Copying,
/// also to a larger extent, is spread over several calls by a bound; meanwhile readers get the last image.
/// Readers may keep an image for any time, in any thread; everything else belongs to one thread.
class MapImage {
 public:
  /// Which cells it has; cell (0, 0) has its lower left corner in the map's origin.
  struct Extent {
    int column{0};  ///< of the leftmost cells
    int row{0};     ///< of the lowest cells
    int width{0};   ///< cells
    int height{0};  ///< cells
    [[nodiscard]] bool operator==(const Extent& other) const;
  };

  explicit MapImage(double resolution_m);

  /// Makes the image writable until the next call of show(), and enlarges it to `wanted` if that takes
  /// copying about `max_cells` cells at most. `wanted` never shrinks from call to call. False: more calls are
  /// needed. Also when it returns true, extent() may still be smaller than `wanted`.
  bool open(const Extent& wanted, std::size_t max_cells);
  [[nodiscard]] const Extent& extent() const { return shown_->extent; }
  /// First of `columns` neighbouring cells within the extent, all of which may be written to after open().
  [[nodiscard]] std::int8_t* cells_at(int column, int row);

  /// O(1).
  [[nodiscard]] std::shared_ptr<const OccupancyGrid> show() const;

 private:
  struct Buffer {
    Extent extent;
    OccupancyGrid grid;                   ///< cells may lack rows at the top during the copy
    std::atomic<std::size_t> readers{0};  ///< outside of this class
  };

  [[nodiscard]] std::shared_ptr<Buffer> blank(const Extent& extent) const;
  /// Copies the next row of the shown buffer to the next one.
  void copy_row();

  double resolution_m_;
  std::shared_ptr<Buffer> shown_;
  std::shared_ptr<Buffer> next_;  ///< copy in progress; null: none
};

}  // namespace extperfc::mapping

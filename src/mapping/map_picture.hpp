#pragma once

#include <atomic>
#include <cstddef>
#include <memory>

#include "extperfc/world/occupancy_grid.hpp"

namespace extperfc::mapping {

/// A grid that is drawn on while others look at it. It is drawn on in place when nobody holds what was shown,
/// else copied first. Copying, also to a larger extent, goes on over as many calls as a bound asks for;
/// meanwhile the last picture is shown. Whoever was shown a picture may hold it for as long as they like, in
/// any thread; all else belongs to one thread.
class MapPicture {
 public:
  /// Which cells it has; cell (0, 0) has its lower left corner in the map's origin.
  struct Extent {
    int column{0};  ///< of the leftmost cells
    int row{0};     ///< of the lowest cells
    int width{0};   ///< cells
    int height{0};  ///< cells
    [[nodiscard]] bool operator==(const Extent& other) const;
  };

  explicit MapPicture(double resolution_m);

  /// Makes it ready to be drawn on, from now to the next call of show(), and as large as `wanted` if that
  /// goes with copying about `most_cells` cells. `wanted` never shrinks from call to call. False: it takes
  /// more calls; the extent stays behind meanwhile, also when this is true.
  bool open(const Extent& wanted, std::size_t most_cells);
  [[nodiscard]] const Extent& extent() const { return shown_->extent; }
  /// First of `columns` neighbouring cells within the extent, all of which may be written to after open().
  [[nodiscard]] std::int8_t* cells_at(int column, int row);

  /// O(1).
  [[nodiscard]] std::shared_ptr<const OccupancyGrid> show() const;

 private:
  struct Sheet {
    Extent extent;
    OccupancyGrid grid;                     ///< cells may lack rows at the top while it is being made
    std::atomic<std::size_t> onlookers{0};  ///< who hold it, outside of this
  };

  [[nodiscard]] std::shared_ptr<Sheet> blank(const Extent& extent) const;
  /// Copies the next row of what is shown to what will be.
  void copy_row();

  double resolution_m_;
  std::shared_ptr<Sheet> shown_;
  std::shared_ptr<Sheet> next_;  ///< being made; null when there is no need
};

}  // namespace extperfc::mapping

#include "mapping/near_mask.hpp"

namespace extperfc::mapping {

NearMask::NearMask(const SurfaceMap& map) {
  const SurfaceMap::Cells cells = map.cells();
  if (cells.columns == 0) return;
  first_column_ = cells.first_column - 1;
  first_row_ = cells.first_row - 1;
  columns_ = cells.columns + 2;
  rows_ = cells.rows + 2;
  blocks_per_row_ = static_cast<std::size_t>(columns_ + 63) / 64;
  blocks_.assign(blocks_per_row_ * static_cast<std::size_t>(rows_), 0);
  map.visit_cells([this](int column, int row) {
    for (int r = row - first_row_ - 1; r <= row - first_row_ + 1; ++r)
      for (int c = column - first_column_ - 1; c <= column - first_column_ + 1; ++c)
        blocks_[block(c, r)] |= std::uint64_t{1} << (c & 63);
  });
}

}  // namespace extperfc::mapping

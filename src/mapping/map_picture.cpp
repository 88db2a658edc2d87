#include "mapping/map_picture.hpp"

namespace extperfc::mapping {

bool MapPicture::Extent::operator==(const Extent& other) const {
  return column == other.column && row == other.row && width == other.width && height == other.height;
}

MapPicture::MapPicture(double resolution_m) : resolution_m_(resolution_m), shown_(blank({})) {}

/// Without cells yet, but with the memory for them: so each is written once, and none before its time.
std::shared_ptr<MapPicture::Sheet> MapPicture::blank(const Extent& extent) const {
  auto sheet = std::make_shared<Sheet>();
  sheet->extent = extent;
  sheet->grid.width = static_cast<std::size_t>(extent.width);
  sheet->grid.height = static_cast<std::size_t>(extent.height);
  sheet->grid.resolution_m = resolution_m_;
  sheet->grid.origin = {extent.column * resolution_m_, extent.row * resolution_m_, 0};
  sheet->grid.cells.reserve(sheet->grid.width * sheet->grid.height);
  return sheet;
}

bool MapPicture::open(const Extent& wanted, std::size_t most_cells) {
  for (std::size_t copied = 0;;) {
    const bool free = shown_->onlookers.load(std::memory_order_acquire) == 0;
    if (free && shown_->extent == wanted) {
      next_.reset();
      return true;
    }
    if (!next_) next_ = blank(wanted);
    const OccupancyGrid& grid = next_->grid;
    for (; grid.cells.size() < grid.width * grid.height; copied += grid.width) {
      if (copied >= most_cells) return false;
      copy_row();
    }
    shown_ = std::move(next_);
    if (copied >= most_cells) return true;
  }
}

void MapPicture::copy_row() {
  const Extent& from = shown_->extent;
  const Extent& to = next_->extent;
  auto& cells = next_->grid.cells;
  const auto width = static_cast<std::size_t>(to.width);
  const int row = to.row + static_cast<int>(cells.size() / width);
  if (row < from.row || row >= from.row + from.height) {
    cells.insert(cells.end(), width, OccupancyGrid::kUnknown);
    return;
  }
  const auto left = static_cast<std::size_t>(from.column - to.column);
  const auto old_width = static_cast<std::size_t>(from.width);
  const auto* old_row = shown_->grid.cells.data() + static_cast<std::size_t>(row - from.row) * old_width;
  cells.insert(cells.end(), left, OccupancyGrid::kUnknown);
  cells.insert(cells.end(), old_row, old_row + old_width);
  cells.insert(cells.end(), width - left - old_width, OccupancyGrid::kUnknown);
}

std::int8_t* MapPicture::cells_at(int column, int row) {
  const auto right = static_cast<std::size_t>(column - shown_->extent.column);
  const auto up = static_cast<std::size_t>(row - shown_->extent.row);
  return shown_->grid.cells.data() + up * shown_->grid.width + right;
}

std::shared_ptr<const OccupancyGrid> MapPicture::show() const {
  shown_->onlookers.fetch_add(1, std::memory_order_relaxed);
  return {&shown_->grid, [sheet = shown_](const OccupancyGrid*) {
            sheet->onlookers.fetch_sub(1, std::memory_order_release);
          }};
}

}  // namespace extperfc::mapping

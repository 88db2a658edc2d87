#include "mapping/map_image.hpp"

namespace extperfc::mapping {

bool MapImage::Extent::operator==(const Extent& other) const {
  return column == other.column && row == other.row && width == other.width && height == other.height;
}

MapImage::MapImage(double resolution_m) : resolution_m_(resolution_m), shown_(blank({})) {}

/// Reserves the memory of the cells without writing them: each is written once, by copy_row().
std::shared_ptr<MapImage::Buffer> MapImage::blank(const Extent& extent) const {
  auto buffer = std::make_shared<Buffer>();
  buffer->extent = extent;
  buffer->grid.width = static_cast<std::size_t>(extent.width);
  buffer->grid.height = static_cast<std::size_t>(extent.height);
  buffer->grid.resolution_m = resolution_m_;
  buffer->grid.origin = {extent.column * resolution_m_, extent.row * resolution_m_, 0};
  buffer->grid.cells.reserve(buffer->grid.width * buffer->grid.height);
  return buffer;
}

bool MapImage::open(const Extent& wanted, std::size_t max_cells) {
  for (std::size_t copied = 0;;) {
    const bool free = shown_->readers.load(std::memory_order_acquire) == 0;
    if (free && shown_->extent == wanted) {
      next_.reset();
      return true;
    }
    if (!next_) next_ = blank(wanted);
    const OccupancyGrid& grid = next_->grid;
    for (; grid.cells.size() < grid.width * grid.height; copied += grid.width) {
      if (copied >= max_cells) return false;
      copy_row();
    }
    shown_ = std::move(next_);
    if (copied >= max_cells) return true;
  }
}

void MapImage::copy_row() {
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

std::int8_t* MapImage::cells_at(int column, int row) {
  const auto right = static_cast<std::size_t>(column - shown_->extent.column);
  const auto up = static_cast<std::size_t>(row - shown_->extent.row);
  return shown_->grid.cells.data() + up * shown_->grid.width + right;
}

std::shared_ptr<const OccupancyGrid> MapImage::show() const {
  shown_->readers.fetch_add(1, std::memory_order_relaxed);
  return {&shown_->grid, [buffer = shown_](const OccupancyGrid*) {
            buffer->readers.fetch_sub(1, std::memory_order_release);
          }};
}

}  // namespace extperfc::mapping

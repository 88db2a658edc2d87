#include "localize/free_space.hpp"

#include <algorithm>
#include <utility>

#include "localize/distance_field.hpp"

namespace extperfc::localize {

namespace {

bool is_free(std::int8_t cell) {
  return cell >= 0 && cell <= kFreeUpTo;
}

}  // namespace

FreeSpace::FreeSpace(std::shared_ptr<const OccupancyGrid> map) : map_(std::move(map)) {
  constexpr std::size_t kRare = 20;  // guesses on average: a list costs four bytes per free cell
  cells_ = static_cast<std::size_t>(std::count_if(map_->cells.begin(), map_->cells.end(), is_free));
  if (cells_ * kRare >= map_->cells.size()) return;
  list_.reserve(cells_);
  for (std::size_t i = 0; i < map_->cells.size(); ++i)
    if (is_free(map_->cells[i])) list_.push_back(static_cast<std::uint32_t>(i));
}

FreeSpace::Point FreeSpace::draw(Rng& rng) const {
  const auto below = [&rng](std::size_t count) {
    return std::min(static_cast<std::size_t>(rng.uniform(0, static_cast<double>(count))), count - 1);
  };
  std::size_t cell = 0;
  if (list_.empty()) {
    do cell = below(map_->cells.size());
    while (!is_free(map_->cells[cell]));
  } else {
    cell = list_[below(list_.size())];
  }
  const std::size_t whole_rows = cell / map_->width;
  const double column = static_cast<double>(cell % map_->width) + rng.uniform(0, 1);
  const double row = static_cast<double>(whole_rows) + rng.uniform(0, 1);
  return {static_cast<float>(column * map_->resolution_m), static_cast<float>(row * map_->resolution_m)};
}

}  // namespace extperfc::localize

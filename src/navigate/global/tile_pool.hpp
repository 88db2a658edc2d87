#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace extperfc::navigate {

/// What a search knows of a cell or block.
struct SearchNode {
  float path_cost{
      std::numeric_limits<float>::infinity()};  ///< from the search's origin; infinite: not reached
  float rest{-1};  ///< estimate of the path cost to the search's target; negative: not asked yet
  std::int32_t parent{-1};
  bool settled{false};
  bool near_path{false};  ///< of a block: about the path over blocks, see BlockSpace::mark_near()
};

/// Squares of a map whose memory is made when a search first enters them and is used again by the next
/// search.
template <typename Tile>
class TilePool {
 public:
  /// Forgets all tiles. Work: those that were in use, not the map.
  void begin(int columns, int rows) {
    const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    if (tiles_.size() == count)
      for (const std::size_t at : used_) tiles_[at] = nullptr;
    else
      tiles_.assign(count, nullptr);
    used_.clear();
    if (pool_.size() > kMaxIdle) pool_.resize(kMaxIdle);
  }
  /// Null unless made since begin().
  [[nodiscard]] Tile* find(std::size_t at) const { return tiles_[at]; }
  /// Its content is what the last search left. Precondition: not found.
  Tile& make(std::size_t at) {
    if (used_.size() == pool_.size()) pool_.push_back(std::make_unique<Tile>());
    tiles_[at] = pool_[used_.size()].get();
    used_.push_back(at);
    return *tiles_[at];
  }
  [[nodiscard]] std::size_t bytes() const {
    return pool_.size() * sizeof(Tile) + tiles_.capacity() * sizeof(Tile*);
  }

 private:
  static constexpr std::size_t kMaxIdle = (std::size_t{128} << 20U) / sizeof(Tile);  ///< 128 MiB are kept

  std::vector<Tile*> tiles_;
  std::vector<std::unique_ptr<Tile>> pool_;
  std::vector<std::size_t> used_;
};

}  // namespace extperfc::navigate

#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/navigate/cost_map.hpp"

namespace extperfc::navigate {

/// Costs that fall with the distance from lethal cells of the layers before. Exact Euclidean distances
/// between the middles of cells (Meijster et al., "A general algorithm for computing distance transforms in
/// linear time", 2000), so that an incremental result is the same as a full one. O(cells of the box). Unknown
/// cells stay unknown.
class InflationLayer : public CostLayer {
 public:
  /// Throws std::invalid_argument unless 0 <= inscribed_radius_m <= radius_m <= 10 and cost_scaling_factor >=
  /// 0.
  explicit InflationLayer(const Inflation& inflation);

  /// Throws as the constructor does.
  void set(const Inflation& inflation);

  void match(const CostGrid& grid) override;
  [[nodiscard]] CellBox take_changes(const CostGrid& grid, double now_s) override;
  void write(CostGrid& grid, const CellBox& box) override;
  [[nodiscard]] int reach_cells(const CostGrid& grid) const override;

 private:
  void fill_table(const CostGrid& grid);
  void note_lethal(const CostGrid& grid, const CellBox& box);

  Inflation inflation_;
  bool changed_{true};
  std::vector<Cost> table_;           ///< by the squared distance [cells^2]
  std::vector<std::uint8_t> lethal_;  ///< cells that the layers before made lethal
};

}  // namespace extperfc::navigate

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "extperfc/world/pose.hpp"

#include "mapping/scan_points.hpp"
#include "mapping/surface_map.hpp"

namespace extperfc::mapping {

/// A surface map as bitmaps of falling resolution: a cell of level l covers 2^l cells of level 0, and is set
/// when any cell is set that a step within it could reach. An upper bound for every pose inside it.
class SearchPyramid {
 public:
  static constexpr float kCellM = 0.1F;
  static constexpr int kLevels = 5;

  explicit SearchPyramid(const SurfaceMap& map);

  /// True when the cell of level 0 at (column, row), or one up to 2^level - 1 right of and above it, is set.
  [[nodiscard]] bool set(int level, int column, int row) const {
    const int c = column - first_column_;
    const int r = row - first_row_;
    if (c < 0 || r < 0 || c >= columns_ || r >= rows_) return false;
    const std::size_t bit =
        static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c);
    return (levels_[static_cast<std::size_t>(level)][bit / 64] >> (bit % 64) & 1U) != 0;
  }

 private:
  int first_column_{0};
  int first_row_{0};
  int columns_{0};
  int rows_{0};
  std::vector<std::vector<std::uint64_t>> levels_;
};

struct SearchWindow {
  Pose2 centre;
  double half_width_m{2};
  double half_yaw_rad{0.2};
};

/// The window, or a little more, so that searches of different windows in one map try the same poses.
[[nodiscard]] SearchWindow on_grid(const SearchWindow& window);

struct FoundPose {
  Pose2 pose;
  double score{0};  ///< fraction of the points that fall on a surface, [0, 1]
};

/// How many poses of a window are wanted, and how far apart.
struct PeakOptions {
  std::size_t count{1};
  double apart_m{1.0};      ///< a pose this far from all better ones is another peak ...
  double apart_rad{0.3};    ///< ... as is one rotated this far
  double within_best{1.0};  ///< of the best score: lower peaks are not looked for
};

/// The best poses in the window whose scores are at least `min_score`, best first, by branch and bound (Hess
/// et al. 2016, Real-Time Loop Closure in 2D LIDAR SLAM, section V). Those found within `max_nodes` computed
/// bounds.
[[nodiscard]] std::vector<FoundPose> search_peaks(const SearchPyramid& pyramid, const ScanPoints& points,
                                                  const SearchWindow& window, double min_score, int max_nodes,
                                                  const PeakOptions& options);

/// The best one.
[[nodiscard]] std::optional<FoundPose> search_wide(const SearchPyramid& pyramid, const ScanPoints& points,
                                                   const SearchWindow& window, double min_score,
                                                   int max_nodes);

}  // namespace extperfc::mapping

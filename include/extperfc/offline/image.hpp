#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "extperfc/base/error.hpp"
#include "extperfc/offline/relations.hpp"
#include "extperfc/world/occupancy_grid.hpp"
#include "extperfc/world/trajectory.hpp"

namespace extperfc::offline {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// A colour image, top row first. Drawing outside of it has no effect.
class Image {
 public:
  Image(std::size_t width, std::size_t height, Color background);

  [[nodiscard]] std::size_t width() const { return width_; }
  [[nodiscard]] std::size_t height() const { return height_; }
  [[nodiscard]] const std::vector<std::uint8_t>& rgb() const { return rgb_; }
  [[nodiscard]] Color at(std::size_t x, std::size_t y) const;

  void set(long x, long y, Color color);
  void line(double x0, double y0, double x1, double y1, Color color);
  void disc(double x, double y, double radius, Color color);
  void rectangle(long x0, long y0, long x1, long y1, Color color);  ///< filled, all ends included

 private:
  std::size_t width_;
  std::size_t height_;
  std::vector<std::uint8_t> rgb_;
};

/// Errors name the file and the reason.
[[nodiscard]] Result<void> write_png(const Image& image, const std::filesystem::path& file);

/// The map as rviz shows it (free white, occupied black, unknown grey) with the path from blue (start, green
/// disc) to red (end, red disc), and a bar whose length is 1, 2, 5, 10, ... m in the lower left corner. One
/// pixel per cell, or a whole number of cells per pixel where a side would be longer than `max_pixels`.
/// Without a map the path alone.
[[nodiscard]] Image draw_map(const OccupancyGrid& map, const Trajectory& trajectory,
                             std::size_t max_pixels = 4000);

/// As above, the path in grey, and every relation as a line between its two scans: green where the error is
/// small, over yellow to red from `bad_m` on; the worst are drawn last, with a disc at the later scan.
[[nodiscard]] Image draw_relations(const OccupancyGrid& map, const std::vector<std::optional<Pose2>>& poses,
                                   const std::vector<Relation>& relations, const RelationsScore& score,
                                   double bad_m = 0.15, std::size_t max_pixels = 4000);

}  // namespace extperfc::offline

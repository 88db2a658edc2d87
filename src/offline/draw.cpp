#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "extperfc/offline/image.hpp"

namespace extperfc::offline {

namespace {

constexpr Color kUnknownColor = {205, 205, 205};
constexpr Color kFreeColor = {254, 254, 254};
constexpr Color kOccupiedColor = {0, 0, 0};
constexpr Color kStartColor = {0, 150, 0};
constexpr Color kEndColor = {220, 0, 0};
constexpr double kMarkPixels = 4;

struct Bounds {
  double x0{std::numeric_limits<double>::infinity()}, y0{x0};
  double x1{-x0}, y1{-x0};

  void take(double x, double y) {
    if (!std::isfinite(x) || !std::isfinite(y)) return;
    x0 = std::min(x0, x), y0 = std::min(y0, y);
    x1 = std::max(x1, x), y1 = std::max(y1, y);
  }
  [[nodiscard]] bool empty() const { return x1 < x0 || y1 < y0; }
};

struct Pixel {
  double x{0};
  double y{0};
};

/// An image of a part of the floor; north (y) is up.
struct Canvas {
  Image image;
  Bounds bounds;
  double metres_per_pixel{0.05};

  [[nodiscard]] Pixel pixel(double x_m, double y_m) const {
    return {(x_m - bounds.x0) / metres_per_pixel,
            static_cast<double>(image.height()) - 1 - (y_m - bounds.y0) / metres_per_pixel};
  }
};

Bounds bounds_of(const OccupancyGrid& map, const std::vector<Pose2>& poses) {
  Bounds bounds;
  for (const auto& pose : poses) bounds.take(pose.x, pose.y);
  if (!map.empty()) {
    for (const std::size_t column : {std::size_t{0}, map.width - 1})
      for (const std::size_t row : {std::size_t{0}, map.height - 1}) {
        const Pose2 corner = map.middle_of({column, row});
        bounds.take(corner.x, corner.y);
      }
  }
  if (bounds.empty()) bounds.take(0, 0);
  constexpr double kMarginM = 0.5;
  bounds.take(bounds.x0 - kMarginM, bounds.y0 - kMarginM);
  bounds.take(bounds.x1 + kMarginM, bounds.y1 + kMarginM);
  return bounds;
}

Canvas make_canvas(const OccupancyGrid& map, const std::vector<Pose2>& poses, std::size_t max_pixels) {
  const Bounds bounds = bounds_of(map, poses);
  const double cell_m = map.empty() ? 0.05 : map.resolution_m;
  const double longest_m = std::max(bounds.x1 - bounds.x0, bounds.y1 - bounds.y0);
  const double cells_per_pixel =
      std::max(1.0, std::ceil(longest_m / cell_m / static_cast<double>(max_pixels)));
  const double metres_per_pixel = cell_m * cells_per_pixel;
  const auto pixels = [&](double length_m) {
    return static_cast<std::size_t>(std::ceil(length_m / metres_per_pixel)) + 1;
  };
  return {Image(pixels(bounds.x1 - bounds.x0), pixels(bounds.y1 - bounds.y0), kUnknownColor), bounds,
          metres_per_pixel};
}

/// Where several cells fall on one pixel an occupied one wins, and then a free one.
void draw_cells(const OccupancyGrid& map, Canvas& canvas) {
  constexpr std::int8_t kRatherOccupied = 50;
  for (const bool occupied : {false, true}) {
    for (std::size_t row = 0; row < map.height; ++row) {
      for (std::size_t column = 0; column < map.width; ++column) {
        const std::int8_t cell = map.at(column, row);
        if (cell == OccupancyGrid::kUnknown || (cell >= kRatherOccupied) != occupied) continue;
        const Pose2 middle = map.middle_of({column, row});
        const Pixel at = canvas.pixel(middle.x, middle.y);
        canvas.image.set(std::lround(at.x), std::lround(at.y), occupied ? kOccupiedColor : kFreeColor);
      }
    }
  }
}

/// Between two colours, ratio in [0, 1].
Color mixed(Color from, Color to, double ratio) {
  Color color{};
  for (std::size_t i = 0; i < color.size(); ++i)
    color[i] = static_cast<std::uint8_t>(std::lround(from[i] + ratio * (to[i] - from[i])));
  return color;
}

void draw_step(Canvas& canvas, const Pose2& from, const Pose2& to, Color color) {
  const Pixel a = canvas.pixel(from.x, from.y);
  const Pixel b = canvas.pixel(to.x, to.y);
  canvas.image.line(a.x, a.y, b.x, b.y, color);
}

/// The longest of 1, 2, 5, 10, ... m that takes at most a third of the image.
void draw_scale(Canvas& canvas) {
  const double room_m = static_cast<double>(canvas.image.width()) * canvas.metres_per_pixel / 3;
  double length_m = 0.01;
  for (double decade = 0.01; decade <= room_m; decade *= 10)
    for (const double step : {1.0, 2.0, 5.0})
      if (decade * step <= room_m) length_m = decade * step;
  constexpr long kMargin = 8;
  constexpr long kThick = 4;
  const long length = std::lround(length_m / canvas.metres_per_pixel);
  const long y = static_cast<long>(canvas.image.height()) - 1 - kMargin;
  canvas.image.rectangle(kMargin - 1, y - kThick - 1, kMargin + length + 1, y + 1, kFreeColor);
  constexpr long kParts = 5;
  for (long part = 0; part < kParts; ++part)
    if (part % 2 == 0)
      canvas.image.rectangle(kMargin + part * length / kParts, y - kThick,
                             kMargin + (part + 1) * length / kParts, y, kOccupiedColor);
}

void draw_ends(Canvas& canvas, const Pose2& start, const Pose2& end) {
  const Pixel first = canvas.pixel(start.x, start.y);
  const Pixel last = canvas.pixel(end.x, end.y);
  canvas.image.disc(first.x, first.y, kMarkPixels, kStartColor);
  canvas.image.disc(last.x, last.y, kMarkPixels, kEndColor);
}

/// Green over yellow to red.
Color error_color(double ratio) {
  constexpr Color kGood = {0, 170, 0};
  constexpr Color kMiddling = {240, 190, 0};
  constexpr Color kBad = {230, 0, 0};
  const double bounded = std::clamp(ratio, 0.0, 1.0);
  return bounded < 0.5 ? mixed(kGood, kMiddling, 2 * bounded) : mixed(kMiddling, kBad, 2 * bounded - 1);
}

}  // namespace

Image draw_map(const OccupancyGrid& map, const Trajectory& trajectory, std::size_t max_pixels) {
  constexpr Color kFirst = {30, 80, 255};
  constexpr Color kLast = {255, 60, 30};
  std::vector<Pose2> poses;
  poses.reserve(trajectory.size());
  for (const auto& stamped : trajectory) poses.push_back(stamped.pose);
  Canvas canvas = make_canvas(map, poses, max_pixels);
  draw_cells(map, canvas);
  for (std::size_t i = 1; i < poses.size(); ++i)
    draw_step(canvas, poses[i - 1], poses[i],
              mixed(kFirst, kLast, static_cast<double>(i) / static_cast<double>(poses.size())));
  if (!poses.empty()) draw_ends(canvas, poses.front(), poses.back());
  draw_scale(canvas);
  return std::move(canvas.image);
}

Image draw_relations(const OccupancyGrid& map, const std::vector<std::optional<Pose2>>& poses,
                     const std::vector<Relation>& relations, const RelationsScore& score, double bad_m,
                     std::size_t max_pixels) {
  constexpr Color kPath = {120, 120, 160};
  std::vector<Pose2> known;
  for (const auto& pose : poses)
    if (pose) known.push_back(*pose);
  Canvas canvas = make_canvas(map, known, max_pixels);
  draw_cells(map, canvas);
  for (std::size_t i = 1; i < known.size(); ++i) draw_step(canvas, known[i - 1], known[i], kPath);
  auto errors = score.errors;
  std::sort(errors.begin(), errors.end(),
            [](const RelationError& a, const RelationError& b) { return a.translation_m < b.translation_m; });
  for (const auto& error : errors) {
    const Pose2& from = *poses[relations[error.relation].from];
    const Pose2& to = *poses[relations[error.relation].to];
    const Color color = error_color(error.translation_m / bad_m);
    draw_step(canvas, from, to, color);
    const Pixel at = canvas.pixel(to.x, to.y);
    canvas.image.disc(at.x, at.y, error.translation_m >= bad_m ? kMarkPixels : 1, color);
  }
  draw_scale(canvas);
  return std::move(canvas.image);
}

}  // namespace extperfc::offline

#include "depth/samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace extperfc::depth {

namespace {

/// Pixels need not be aligned, hence memcpy.
template <typename Pixel>
float read_m(const std::uint8_t* bytes) {
  Pixel value{};
  std::memcpy(&value, bytes, sizeof value);
  if constexpr (sizeof value == 2) return 0.001F * static_cast<float>(value);
  return static_cast<float>(value);
}

template <typename Pixel>
void collect_pixels(const ImageView& depth, const Region& region, const Box2& box,
                    const BoxDepthParams& params, Samples& out) {
  const auto min_m = static_cast<float>(params.min_depth_m);
  const auto max_m = static_cast<float>(params.max_depth_m);
  for (int y = region.y0 + out.step / 2; y < region.y1; y += out.step) {
    const std::uint8_t* const row = depth.row(y);
    const float dy = static_cast<float>(y) + 0.5F - box.center_y();
    for (int x = region.x0 + out.step / 2; x < region.x1; x += out.step) {
      const float z = read_m<Pixel>(row + static_cast<std::size_t>(x) * sizeof(Pixel));
      ++out.looked_at;
      if (!(z >= min_m && z <= max_m)) continue;  // NaN compares false
      out.items[static_cast<std::size_t>(out.size++)] = {static_cast<float>(x) + 0.5F - box.center_x(), dy,
                                                         z};
    }
  }
}

int grid_points(const Region& region, int step) {
  return ((region.width() + step - 1) / step) * ((region.height() + step - 1) / step);
}

int grid_step(const Region& region) {
  const double area = static_cast<double>(region.width()) * region.height();
  int step = std::max(1, static_cast<int>(std::sqrt(area / Samples::kCapacity)));
  while (grid_points(region, step) > Samples::kCapacity) ++step;
  return step;
}

}  // namespace

std::optional<Box2> clip_box(const Box2& box, int width, int height) {
  const bool finite = std::isfinite(box.x_min) && std::isfinite(box.y_min) && std::isfinite(box.x_max) &&
                      std::isfinite(box.y_max);
  if (!finite) return std::nullopt;
  const Box2 inside{std::max(box.x_min, 0.0F), std::max(box.y_min, 0.0F),
                    std::min(box.x_max, static_cast<float>(width)),
                    std::min(box.y_max, static_cast<float>(height))};
  if (!(inside.width() > 0.0F && inside.height() > 0.0F)) return std::nullopt;
  return inside;
}

Region center_window(const Box2& box, int side, int width, int height) {
  const auto start = [side](float center) {
    return static_cast<int>(std::lround(center - 0.5F * static_cast<float>(side)));
  };
  const int x0 = start(box.center_x());
  const int y0 = start(box.center_y());
  return {std::max(x0, 0), std::max(y0, 0), std::min(x0 + side, width), std::min(y0 + side, height)};
}

Region central_part(const Box2& box, double fraction, int width, int height) {
  const double half_w = 0.5 * fraction * box.width();
  const double half_h = 0.5 * fraction * box.height();
  return {std::max(static_cast<int>(std::floor(box.center_x() - half_w)), 0),
          std::max(static_cast<int>(std::floor(box.center_y() - half_h)), 0),
          std::min(static_cast<int>(std::ceil(box.center_x() + half_w)), width),
          std::min(static_cast<int>(std::ceil(box.center_y() + half_h)), height)};
}

void collect(const ImageView& depth, const Region& region, const Box2& box, const BoxDepthParams& params,
             Samples& out) {
  out.size = 0;
  out.looked_at = 0;
  if (region.empty()) return;
  out.step = grid_step(region);
  if (depth.format == PixelFormat::kDepth16Mm)
    collect_pixels<std::uint16_t>(depth, region, box, params, out);
  else
    collect_pixels<float>(depth, region, box, params, out);
}

}  // namespace extperfc::depth

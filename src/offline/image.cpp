#include "extperfc/offline/image.hpp"

#include <algorithm>
#include <cmath>

#include "extperfc/world/png_file.hpp"

namespace extperfc::offline {

Image::Image(std::size_t width, std::size_t height, Color background)
    : width_(width), height_(height), rgb_(width * height * background.size()) {
  for (std::size_t i = 0; i < rgb_.size(); ++i) rgb_[i] = background[i % background.size()];
}

Color Image::at(std::size_t x, std::size_t y) const {
  const std::size_t i = 3 * (y * width_ + x);
  return {rgb_[i], rgb_[i + 1], rgb_[i + 2]};
}

void Image::set(long x, long y, Color color) {
  if (x < 0 || y < 0 || x >= static_cast<long>(width_) || y >= static_cast<long>(height_)) return;
  const std::size_t i = 3 * (static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x));
  std::copy(color.begin(), color.end(), rgb_.begin() + static_cast<std::ptrdiff_t>(i));
}

void Image::line(double x0, double y0, double x1, double y1, Color color) {
  constexpr double kLongest = 1e6;  // poses gone astray
  const double length = std::max(std::abs(x1 - x0), std::abs(y1 - y0));
  if (!(length < kLongest)) return;
  const int steps = std::max(1, static_cast<int>(std::ceil(length)));
  for (int i = 0; i <= steps; ++i) {
    const double ratio = static_cast<double>(i) / steps;
    set(std::lround(x0 + ratio * (x1 - x0)), std::lround(y0 + ratio * (y1 - y0)), color);
  }
}

void Image::disc(double x, double y, double radius, Color color) {
  if (!std::isfinite(x) || !std::isfinite(y)) return;
  const long reach = std::lround(std::ceil(radius));
  for (long dy = -reach; dy <= reach; ++dy)
    for (long dx = -reach; dx <= reach; ++dx)
      if (static_cast<double>(dx * dx + dy * dy) <= radius * radius)
        set(std::lround(x) + dx, std::lround(y) + dy, color);
}

void Image::rectangle(long x0, long y0, long x1, long y1, Color color) {
  for (long y = y0; y <= y1; ++y)
    for (long x = x0; x <= x1; ++x) set(x, y, color);
}

Result<void> write_png(const Image& image, const std::filesystem::path& file) {
  return extperfc::write_png({image.width(), image.height(), PngLayout::kRgb, image.rgb().data()}, file);
}

}  // namespace extperfc::offline

#include "face/lbp.hpp"

#include <array>
#include <cmath>

namespace extperfc::face {

namespace {

constexpr int kNeighbours = 8;
constexpr int kPatterns = 256;
constexpr int kMaxChanges = 2;
constexpr float kEqual = 1e-3F;  // grey levels: rounding must not make equal pixels darker

int changes_around(int pattern) {
  int changes = 0;
  for (int i = 0; i < kNeighbours; ++i)
    changes += ((pattern >> i) & 1) != ((pattern >> ((i + 1) % kNeighbours)) & 1) ? 1 : 0;
  return changes;
}

std::array<std::uint8_t, kPatterns> make_bin_table() {
  std::array<std::uint8_t, kPatterns> table{};
  int next = 0;
  for (int pattern = 0; pattern < kPatterns; ++pattern)
    table[static_cast<std::size_t>(pattern)] =
        static_cast<std::uint8_t>(changes_around(pattern) <= kMaxChanges ? next++ : kLbpBins - 1);
  return table;
}

/// A neighbour between four pixels.
struct Neighbour {
  int x, y;                     ///< of the upper left pixel, relative to the middle
  std::array<float, 4> weight;  ///< upper left, upper right, lower left, lower right
};

std::array<Neighbour, kNeighbours> make_neighbours() {
  std::array<Neighbour, kNeighbours> neighbours{};
  for (int i = 0; i < kNeighbours; ++i) {
    const double angle = i * (2.0 * M_PI / kNeighbours);
    // Rounded, so that neighbours on the axes are pixels.
    const double x = std::round(1e6 * kLbpRadius * std::cos(angle)) * 1e-6;
    const double y = std::round(-1e6 * kLbpRadius * std::sin(angle)) * 1e-6;
    const auto right = static_cast<float>(x - std::floor(x));
    const auto lower = static_cast<float>(y - std::floor(y));
    neighbours[static_cast<std::size_t>(i)] = {
        static_cast<int>(std::floor(x)),
        static_cast<int>(std::floor(y)),
        {(1 - right) * (1 - lower), right * (1 - lower), (1 - right) * lower, right * lower}};
  }
  return neighbours;
}

/// Reads no pixel that has the weight 0: it may lie outside.
float value_at(const cv::Mat1b& grey, int x, int y, const Neighbour& neighbour) {
  float sum = 0.0F;
  for (int i = 0; i < 4; ++i) {
    const float weight = neighbour.weight[static_cast<std::size_t>(i)];
    if (weight > 0.0F)
      sum += weight * static_cast<float>(grey(y + neighbour.y + i / 2, x + neighbour.x + i % 2));
  }
  return sum;
}

}  // namespace

int lbp_bin(std::uint8_t pattern) {
  static const auto table = make_bin_table();
  return table[pattern];
}

cv::Mat1b lbp_bins(const cv::Mat1b& grey) {
  static const auto neighbours = make_neighbours();
  cv::Mat1b bins(grey.rows - 2 * kLbpRadius, grey.cols - 2 * kLbpRadius);
  for (int y = 0; y < bins.rows; ++y)
    for (int x = 0; x < bins.cols; ++x) {
      const float middle = static_cast<float>(grey(y + kLbpRadius, x + kLbpRadius)) - kEqual;
      unsigned pattern = 0;
      for (std::size_t i = 0; i < kNeighbours; ++i)
        if (value_at(grey, x + kLbpRadius, y + kLbpRadius, neighbours[i]) >= middle) pattern |= 1U << i;
      bins(y, x) = static_cast<std::uint8_t>(lbp_bin(static_cast<std::uint8_t>(pattern)));
    }
  return bins;
}

std::vector<float> lbp_histograms(const cv::Mat1b& bins, int cells) {
  std::vector<float> histograms(static_cast<std::size_t>(cells * cells) * kLbpBins);
  for (int row = 0; row < cells; ++row)
    for (int column = 0; column < cells; ++column) {
      const cv::Mat1b cell = bins(cv::Range(row * bins.rows / cells, (row + 1) * bins.rows / cells),
                                  cv::Range(column * bins.cols / cells, (column + 1) * bins.cols / cells));
      float* histogram = histograms.data() + static_cast<std::size_t>(row * cells + column) * kLbpBins;
      const float one = 1.0F / static_cast<float>(cell.total());
      for (const std::uint8_t bin : cell) histogram[bin] += one;
    }
  return histograms;
}

}  // namespace extperfc::face

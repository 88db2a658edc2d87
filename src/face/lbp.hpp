#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

namespace extperfc::face {

inline constexpr int kLbpBins = 59;   ///< 58 uniform patterns of 8 bits, and one bin for all others
inline constexpr int kLbpRadius = 2;  ///< pixels

/// The bin of a pattern: those with at most two changes between 0 and 1 around the circle have one each, in
/// ascending order (Ojala et al. 2002, uniform patterns).
[[nodiscard]] int lbp_bin(std::uint8_t pattern);

/// The bin of every pixel of a CV_8UC1 image that is kLbpRadius or more away from its border; CV_8UC1,
/// smaller by 2 kLbpRadius in both directions. Bit i of a pattern: the neighbour at the angle i * 45 degrees,
/// bilinear, is not darker than the pixel.
[[nodiscard]] cv::Mat1b lbp_bins(const cv::Mat1b& grey);

/// One histogram per cell of a cells x cells grid, row after row, each with the sum 1.
[[nodiscard]] std::vector<float> lbp_histograms(const cv::Mat1b& bins, int cells);

}  // namespace extperfc::face

// Local binary patterns of small images.
#include <numeric>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "face/lbp.hpp"

namespace extperfc::face {
namespace {

cv::Mat1b random_image(int size, std::uint64_t seed) {
  Rng rng(seed);
  cv::Mat1b image(size, size);
  for (auto& pixel : image) pixel = static_cast<std::uint8_t>(rng.uniform(10, 100));
  return image;
}

TEST(Lbp, FiftyEightPatternsAreUniform) {
  std::set<int> bins;
  int others = 0;
  for (int pattern = 0; pattern < 256; ++pattern) {
    const int bin = lbp_bin(static_cast<std::uint8_t>(pattern));
    bins.insert(bin);
    others += bin == kLbpBins - 1 ? 1 : 0;
  }
  EXPECT_EQ(bins.size(), 59U);
  EXPECT_EQ(*bins.rbegin(), 58);
  EXPECT_EQ(others, 198);
  EXPECT_NE(lbp_bin(0b00000111), lbp_bin(0b00001110)) << "directions differ";
  EXPECT_EQ(lbp_bin(0b00000101), lbp_bin(0b01010101)) << "neither is uniform";
}

TEST(Lbp, PatternsAreThoseOfAnEdge) {
  cv::Mat1b flat(9, 9, std::uint8_t{50});
  EXPECT_EQ(lbp_bins(flat)(2, 2), lbp_bin(0xff)) << "equal neighbours are not darker";
  cv::Mat1b spot = flat.clone();
  spot(4, 4) = 60;
  EXPECT_EQ(lbp_bins(spot)(2, 2), lbp_bin(0));
  cv::Mat1b edge = flat.clone();
  edge.colRange(5, 9).setTo(200);
  edge.colRange(0, 4).setTo(10);
  // Neighbours at 0, 45, 90, 270 and 315 degrees are not darker.
  EXPECT_EQ(lbp_bins(edge)(2, 2), lbp_bin(0b11000111));
}

TEST(Lbp, BrightnessAndContrastDoNotMatter) {
  const cv::Mat1b image = random_image(32, 5);
  cv::Mat1b brighter;
  image.convertTo(brighter, CV_8U, 2.0, 7.0);  // exact, without saturation
  EXPECT_EQ(cv::countNonZero(lbp_bins(image) != lbp_bins(brighter)), 0);
  const cv::Mat1b other = random_image(32, 6);
  EXPECT_GT(cv::countNonZero(lbp_bins(image) != lbp_bins(other)), 300);
}

TEST(Lbp, EveryCellCountsItsPixels) {
  cv::Mat1b bins(10, 10, std::uint8_t{3});
  bins(0, 0) = 7;                                 // of the first cell
  bins.rowRange(5, 10).colRange(5, 10).setTo(9);  // the last cell
  const auto histograms = lbp_histograms(bins, 2);
  ASSERT_EQ(histograms.size(), 4U * kLbpBins);
  EXPECT_NEAR(histograms[3], 24.0F / 25, 1e-5F);
  EXPECT_NEAR(histograms[7], 1.0F / 25, 1e-5F);
  EXPECT_NEAR(histograms[3 * kLbpBins + 9], 1.0F, 1e-5F);
  for (int cell = 0; cell < 4; ++cell)
    EXPECT_NEAR(std::accumulate(histograms.begin() + cell * kLbpBins,
                                histograms.begin() + (cell + 1) * kLbpBins, 0.0F),
                1.0F, 1e-5F);
}

}  // namespace
}  // namespace extperfc::face

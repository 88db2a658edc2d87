#pragma once

#include <array>
#include <vector>

#include <opencv2/core.hpp>

namespace extperfc::detect {

/// One channel of the result: value * scale + offset.
struct AreaPlane {
  cv::Mat pixels;  ///< CV_32FC1 of the result's size; may be a part of a larger matrix
  int channel{0};  ///< of the image
  double scale{1};
  double offset{0};
};

/// Makes 8-bit images smaller: each pixel of the result is the mean of the image over the pixel's area,
/// as cv::INTER_AREA computes it. It is rounded to whole grey levels as there, since networks are trained
/// with such images: unrounded, FastestDet's scores move by up to 0.02, rounded by 0.006. A uniform image
/// keeps its value exactly.
class AreaResizer {
 public:
  /// Whether run() supports it: 1, 3 or 4 channels of 8 bits, larger on no axis and smaller on one at
  /// least. Not for half the size, where OpenCV is faster.
  [[nodiscard]] static bool suits(const cv::Mat& image, cv::Size result);

  /// Allocates only when the image's or the result's size differs from the last call's. The planes must
  /// share one size and must not overlap the image.
  void run(const cv::Mat& image, std::array<AreaPlane, 3>& planes);

 private:
  /// Which of the `from` pixels of one axis make each of its `to` pixels, and with which weights. All pixels
  /// have `taps` weights, the surplus ones are zero.
  struct Axis {
    int from{0};
    int to{0};
    int taps{0};
    std::vector<int> starts;
    std::vector<float> weights;  ///< weight t of pixel i at [i * taps + t]
  };

  [[nodiscard]] static Axis make_axis(int from, int to);
  void prepare(const cv::Mat& image, cv::Size result);
  void sum_rows(const cv::Mat& image, int y);
  void write_row(int y, std::array<AreaPlane, 3>& planes) const;

  Axis columns_;
  Axis rows_;
  int channels_{0};
  std::vector<int> block_starts_;     ///< columns_.starts as places in row_, filled up to whole blocks
  std::vector<float> block_weights_;  ///< weight t of pixel p of block b at [(b * taps + t) * kBlock + p]
  std::vector<float> row_;            ///< one row of the result at the image's width, channels interleaved
};

}  // namespace extperfc::detect

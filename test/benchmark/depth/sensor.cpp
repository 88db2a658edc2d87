#include "test/benchmark/depth/sensor.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "extperfc/base/math.hpp"

namespace extperfc::benchmark {

namespace {
constexpr double kSmoothPx = 12.0;         // blur of the part of the noise that an object shares
constexpr double kJump = 0.03;             // relative depth difference between neighbours that is an edge
constexpr int kEdgeReachPx = 2;            // pixels on both sides of an edge that suffer
constexpr double kLostAtEdge = 0.5;        // probability
constexpr double kFlyingAtEdge = 0.25;     // probability
constexpr double kPixelsPerHole = 4000.0;  // mean area of image per hole

/// Unit-variance noise, white noise blurred by a Gaussian. Blurring divides the variance by 4 pi sigma^2,
/// which is also the area that moves together.
cv::Mat smooth_noise(cv::Size size, double sigma_px, Rng& rng) {
  cv::Mat noise(size, CV_32FC1);
  cv::RNG generator(static_cast<std::uint64_t>(rng.integer(1, std::numeric_limits<int>::max())));
  generator.fill(noise, cv::RNG::NORMAL, 0.0, std::sqrt(4.0 * kPi) * sigma_px);
  cv::GaussianBlur(noise, noise, {}, sigma_px, sigma_px, cv::BORDER_REFLECT);
  return noise;
}

/// Pixels next to a depth jump. Compares direct neighbours, so that a floor at a grazing angle is no edge.
cv::Mat edges_of(const cv::Mat& truth) {
  cv::Mat low;
  cv::Mat high;
  cv::erode(truth, low, cv::Mat::ones(3, 3, CV_8UC1));
  cv::dilate(truth, high, cv::Mat::ones(3, 3, CV_8UC1));
  cv::Mat edges = (high - low) > kJump * low;
  const int side = 2 * kEdgeReachPx - 1;  // the comparison reached one pixel already
  cv::dilate(edges, edges, cv::Mat::ones(side, side, CV_8UC1));
  return edges;
}

void damage_edges(const cv::Mat& truth, cv::Mat& depth, Rng& rng) {
  const cv::Mat kernel = cv::Mat::ones(2 * kEdgeReachPx + 1, 2 * kEdgeReachPx + 1, CV_8UC1);
  const cv::Mat edges = edges_of(truth);
  cv::Mat low;
  cv::Mat high;
  cv::erode(truth, low, kernel);
  cv::dilate(truth, high, kernel);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      auto& z = depth.at<float>(v, u);
      if (z <= 0.0F || edges.at<std::uint8_t>(v, u) == 0) continue;
      const double dice = rng.uniform(0.0, 1.0);
      if (dice < kLostAtEdge)
        z = 0.0F;
      else if (dice < kLostAtEdge + kFlyingAtEdge)
        z = static_cast<float>(rng.uniform(low.at<float>(v, u), high.at<float>(v, u)));
    }
  }
}

void punch_holes(cv::Mat& depth, Rng& rng) {
  const double expected = static_cast<double>(depth.total()) / kPixelsPerHole;
  const int holes = rng.integer(0, static_cast<int>(2.0 * expected + 0.5));
  for (int i = 0; i < holes; ++i) {
    const cv::Point center(rng.integer(0, depth.cols - 1), rng.integer(0, depth.rows - 1));
    cv::circle(depth, center, rng.integer(1, 6), cv::Scalar(0.0), cv::FILLED);
  }
}

}  // namespace

void StereoSensor::drop_occluded(cv::Mat& depth) const {
  const auto disparity_m = static_cast<float>(camera_.fx * noise_.baseline_m);
  for (int v = 0; v < depth.rows; ++v) {
    float leftmost =
        std::numeric_limits<float>::infinity();  // place in the right image, of all pixels so far
    for (int u = depth.cols - 1; u >= 0; --u) {
      auto& z = depth.at<float>(v, u);
      if (z <= 0.0F) continue;
      const float place = static_cast<float>(u) - disparity_m / z;
      if (place > leftmost) z = 0.0F;
      leftmost = std::min(leftmost, place);
    }
  }
}

void StereoSensor::add_noise(cv::Mat& depth, Rng& rng) const {
  const double patch_sigma_px = noise_.correlation_px / std::sqrt(4.0 * kPi);
  const cv::Mat fine = smooth_noise(depth.size(), patch_sigma_px, rng);
  const cv::Mat common = smooth_noise(depth.size(), kSmoothPx, rng);
  const double sigma = noise_.sigma_inverse_depth();
  const double fine_sigma = sigma * std::sqrt(1.0 - noise_.common_fraction);
  const double common_sigma = sigma * std::sqrt(noise_.common_fraction);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      auto& z = depth.at<float>(v, u);
      if (z <= 0.0F) continue;
      const double inverse =
          1.0 / z + fine_sigma * fine.at<float>(v, u) + common_sigma * common.at<float>(v, u);
      z = inverse > 0.0 ? static_cast<float>(1.0 / inverse) : 0.0F;
    }
  }
}

cv::Mat StereoSensor::measure(const Rendering& rendering, Rng& rng) const {
  const cv::Mat truth = rendering.depth(rendering.part);
  cv::Mat depth = truth.clone();
  drop_occluded(depth);
  damage_edges(truth, depth, rng);
  punch_holes(depth, rng);
  add_noise(depth, rng);
  cv::Mat image = cv::Mat::zeros(rendering.depth.size(), CV_16UC1);
  depth.convertTo(image(rendering.part), CV_16U, 1000.0);
  return image;
}

}  // namespace extperfc::benchmark

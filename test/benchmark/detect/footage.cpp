#include "test/benchmark/detect/footage.hpp"

#include <cstdint>

#include <opencv2/imgproc.hpp>

#include "extperfc/sources/recording.hpp"

namespace extperfc::benchmark {

namespace {

constexpr double kFocalPx = 525.0;  // at 640 pixels width, PrimeSense class

CameraModel nominal_camera(const cv::Size& size) {
  const double focal_px = kFocalPx * size.width / 640.0;
  return {size.width, size.height, focal_px, focal_px, 0.5 * (size.width - 1), 0.5 * (size.height - 1), {}};
}

/// A wall whose brightness changes, with noise: nothing is easier for one library than for another.
ImagePair empty_room(const cv::Size& size) {
  constexpr std::uint64_t kSeed = 1;
  cv::Mat wall(size, CV_8UC3);
  for (int y = 0; y < size.height; ++y) wall.row(y).setTo(cv::Scalar(150 - y / 8, 160 - y / 8, 170 - y / 10));
  cv::Mat noise(size, CV_8UC3);
  cv::RNG(kSeed).fill(noise, cv::RNG::UNIFORM, 0, 12);
  return {wall + noise, cv::Mat(size, CV_16UC1, cv::Scalar(3000))};
}

void fill(ImagePair& image, const std::vector<cv::Point>& outline, const cv::Scalar& color,
          std::uint16_t depth_mm) {
  cv::fillConvexPoly(image.color, outline, color, cv::LINE_AA);
  cv::fillConvexPoly(image.depth, outline, cv::Scalar(depth_mm));
}

void draw_cone(ImagePair& image) {
  fill(image, {{130, 180}, {190, 330}, {70, 330}}, {30, 90, 220}, 900);
  fill(image, {{130, 180}, {145, 220}, {130, 330}, {85, 330}}, {50, 130, 250}, 880);
}

void draw_cube(ImagePair& image) {
  fill(image, {{260, 240}, {350, 240}, {350, 330}, {260, 330}}, {180, 90, 40}, 1000);
  fill(image, {{260, 240}, {285, 215}, {375, 215}, {350, 240}}, {220, 140, 90}, 1030);
  fill(image, {{350, 240}, {375, 215}, {375, 305}, {350, 330}}, {130, 60, 25}, 1030);
}

void draw_sphere(ImagePair& image, const cv::Point& center, int radius, const cv::Scalar& color) {
  constexpr int kRings = 24;
  for (int ring = kRings; ring > 0; --ring) {
    const double light = 1.25 - 0.75 * ring / kRings;
    const cv::Point shift(-radius * (kRings - ring) / (3 * kRings), -radius * (kRings - ring) / (3 * kRings));
    cv::circle(image.color, center + shift, radius * ring / kRings, light * color, cv::FILLED, cv::LINE_AA);
  }
  cv::circle(image.depth, center, radius, cv::Scalar(1100), cv::FILLED);
}

Result<Footage> images_of(sources::Recording& recording) {
  Footage footage;
  for (std::size_t i = 0; i < recording.size(); ++i) {
    auto frame = recording.frame(i);
    if (!frame) return tl::unexpected(frame.error());
    if (frame->color.type() != CV_8UC3 || frame->depth.type() != CV_16UC1 ||
        frame->color.size() != frame->depth.size())
      continue;
    footage.images.push_back({frame->color, frame->depth});
  }
  return footage;
}

}  // namespace

Result<Footage> load_footage(const std::filesystem::path& folder) {
  auto recording = sources::open_pair_folder(folder);
  if (!recording) return tl::unexpected(recording.error());
  auto footage = images_of(**recording);
  if (!footage) return footage;
  if (footage->images.empty())
    return fail(ErrorCode::kNotFound,
                folder.string() + " has no colour image with an aligned 16-bit depth image of the same size");
  footage->camera = (*recording)->camera().value_or(nominal_camera(footage->images.front().color.size()));
  return footage;
}

Footage draw_footage() {
  const cv::Size size(640, 480);
  ImagePair image = empty_room(size);
  draw_cone(image);
  draw_cube(image);
  draw_sphere(image, {480, 290}, 55, {40, 140, 235});
  draw_sphere(image, {560, 400}, 45, {60, 190, 70});
  return {{image}, nominal_camera(size)};
}

}  // namespace extperfc::benchmark

#include <cmath>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "extperfc/sources/recording.hpp"

#include "sources/pair_list.hpp"
#include "sources/recorded_poses.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;

constexpr double kMillimetresPerMetre = 1000.0;

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}
std::string size_text(const cv::Mat& image) {
  return size_text(image.cols, image.rows);
}

Result<cv::Mat> read_image(const fs::path& file, int flags) {
  try {
    cv::Mat image = cv::imread(file.string(), flags);
    if (!image.empty()) return image;
  } catch (const cv::Exception&) {  // e.g. larger than OpenCV's own limit: the same message
  }
  return fail(ErrorCode::kCorrupt,
              "cannot read " + file.string() + ": not a PNG or JPEG image, damaged or too large");
}

/// 16-bit depth in millimetres. Values beyond 65.535 m saturate.
Result<cv::Mat> read_depth(const fs::path& file, double depth_scale) {
  auto depth = read_image(file, cv::IMREAD_UNCHANGED);
  if (!depth) return depth;
  if (depth->type() != CV_16UC1)
    return fail(ErrorCode::kCorrupt, file.string() + " is " + cv::typeToString(depth->type()) +
                                         " instead of 16-bit grey (CV_16UC1): not a depth image");
  if (depth_scale != kMillimetresPerMetre)
    depth->convertTo(*depth, CV_16U, kMillimetresPerMetre / depth_scale);
  return depth;
}

class PairFolder : public Recording {
 public:
  PairFolder(std::vector<Pair> pairs, std::optional<CameraModel> camera, RecordedPoses poses,
             double depth_scale)
      : pairs_(std::move(pairs)), camera_(camera), poses_(std::move(poses)), depth_scale_(depth_scale) {}

  [[nodiscard]] std::size_t size() const override { return pairs_.size(); }
  [[nodiscard]] std::optional<CameraModel> camera() const override { return camera_; }
  [[nodiscard]] Result<RgbdFrame> frame(std::size_t index) override;

 private:
  /// EXIF orientation is ignored: a rotated image would no longer fit its depth.
  static constexpr int kColorFlags = cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION;

  std::vector<Pair> pairs_;
  std::optional<CameraModel> camera_;
  RecordedPoses poses_;
  double depth_scale_;
};

Result<RgbdFrame> PairFolder::frame(std::size_t index) {
  if (index >= pairs_.size())
    return fail(ErrorCode::kInvalidArgument,
                "frame " + std::to_string(index) + " of a recording with " + std::to_string(pairs_.size()));
  const Pair& pair = pairs_[index];
  auto color = read_image(pair.color, kColorFlags);
  if (!color) return tl::unexpected(color.error());
  if (camera_ && (color->cols != camera_->width || color->rows != camera_->height))
    return fail(ErrorCode::kInvalidArgument, pair.color.string() + " is " + size_text(*color) +
                                                 " but camera_info.yaml describes " +
                                                 size_text(camera_->width, camera_->height));
  RgbdFrame frame{
      pair.stamp_s, *std::move(color), {}, poses_.at(pair.stamp_s), pair.color.filename().string()};
  if (pair.depth.empty()) return frame;
  auto depth = read_depth(pair.depth, depth_scale_);
  if (!depth) return tl::unexpected(depth.error());
  if (depth->size() != frame.color.size())
    return fail(ErrorCode::kInvalidArgument, pair.color.string() + " is " + size_text(frame.color) + " but " +
                                                 pair.depth.string() + " is " + size_text(*depth) +
                                                 "; depth must be aligned to colour");
  frame.depth = *std::move(depth);
  return frame;
}

}  // namespace

Result<std::unique_ptr<Recording>> open_pair_folder(const fs::path& folder, double depth_scale) {
  if (!(std::isfinite(depth_scale) && depth_scale > 0.0))
    return fail(ErrorCode::kInvalidArgument, "depth scale " + std::to_string(depth_scale) +
                                                 " must be positive: units per metre, 1000 for millimetres");
  auto pairs = list_pairs(folder);
  if (!pairs) return tl::unexpected(pairs.error());
  std::optional<CameraModel> camera;
  std::error_code ignored;
  if (const auto file = folder / "camera_info.yaml"; fs::exists(file, ignored)) {
    const auto loaded = load_camera_yaml(file);
    if (!loaded) return tl::unexpected(loaded.error());
    camera = *loaded;
  }
  Result<RecordedPoses> poses;
  if (const auto file = folder / "groundtruth.txt"; fs::exists(file, ignored)) {
    poses = RecordedPoses::load(file);
    if (!poses) return tl::unexpected(poses.error());
  }
  return std::make_unique<PairFolder>(*std::move(pairs), camera, *std::move(poses), depth_scale);
}

}  // namespace extperfc::sources

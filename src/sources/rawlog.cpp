#include <exception>
#include <mutex>
#include <system_error>
#include <utility>

#include <mrpt/core/Clock.h>
#include <mrpt/img/CImage.h>
#include <opencv2/core.hpp>

#include "extperfc/sources/recording.hpp"

#include "sources/mrpt_errors.hpp"
#include "sources/rawlog_reader.hpp"
#include "sources/rawlog_scan.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;
using Scan = RawlogReader::Scan;

/// Where MRPT's programs put images that they store beside a rawlog.
fs::path image_folder(const fs::path& rawlog) {
  const fs::path parent = rawlog.parent_path();
  for (const char* suffix : {"_Images", "_images", "_IMAGES"}) {
    std::error_code ignored;
    fs::path folder = parent / (rawlog.stem().string() + suffix);
    if (fs::is_directory(folder, ignored)) return folder;
  }
  return parent / "Images";
}

/// Frames are read when asked for: forward is streaming, backward starts again at the beginning of the file.
class Rawlog : public Recording {
 public:
  explicit Rawlog(fs::path file) : file_(std::move(file)) {}

  /// Counts the observations by reading the file once. A damaged end becomes one last frame that reports it.
  [[nodiscard]] Result<void> index();

  [[nodiscard]] std::size_t size() const override { return size_ + (damage_.empty() ? 0 : 1); }
  [[nodiscard]] std::optional<CameraModel> camera() const override { return camera_; }
  [[nodiscard]] Result<RgbdFrame> frame(std::size_t index) override;

 private:
  [[nodiscard]] Scan seek(std::size_t index);
  [[nodiscard]] Result<RgbdFrame> convert(const Scan& scan, std::size_t index);
  [[nodiscard]] std::string label(std::size_t index) const {
    return file_.filename().string() + "#" + std::to_string(index);
  }

  fs::path file_;
  std::size_t size_{0};
  std::string damage_;
  std::optional<CameraModel> camera_;
  std::unique_ptr<RawlogReader> reader_;
  std::size_t next_{0};  // index of the observation that reader_ returns next
  ScanAligner aligner_;
};

Result<void> Rawlog::index() {
  std::error_code ignored;
  if (!fs::is_regular_file(file_, ignored))
    return fail(ErrorCode::kNotFound, "no such file: " + file_.string());
  try {
    RawlogReader reader(file_);
    if (!reader.is_open()) return fail(ErrorCode::kFailed, "cannot open " + file_.string());
    while (const Scan scan = reader.next()) {
      if (size_++ > 0) continue;
      const auto camera =
          camera_from_mrpt(scan->hasIntensityImage ? scan->cameraParamsIntensity : scan->cameraParams);
      if (camera) camera_ = *camera;
    }
  } catch (const std::exception& e) {
    damage_ = file_.string() + " is damaged or breaks off: " + sentence_of(e);
  }
  if (size_ > 0) return {};
  if (!damage_.empty()) return fail(ErrorCode::kCorrupt, damage_);
  return fail(ErrorCode::kNotFound, file_.string() + " holds no RGB-D observation (CObservation3DRangeScan)");
}

Scan Rawlog::seek(std::size_t index) {
  if (!reader_ || index < next_) {
    reader_ = std::make_unique<RawlogReader>(file_);
    next_ = 0;
  }
  Scan scan;
  while (next_ <= index) {
    scan = reader_->next();
    ++next_;
  }
  return scan;
}

Result<RgbdFrame> Rawlog::frame(std::size_t index) {
  if (index >= size())
    return fail(ErrorCode::kInvalidArgument,
                "frame " + std::to_string(index) + " of a recording with " + std::to_string(size()));
  if (index == size_) return fail(ErrorCode::kCorrupt, damage_);
  try {
    const Scan scan = seek(index);
    if (scan) return convert(scan, index);
    return fail(ErrorCode::kCorrupt, file_.string() + " has become shorter while it was read");
  } catch (const std::exception& e) {
    reader_.reset();
    return fail(ErrorCode::kCorrupt, label(index) + ": " + sentence_of(e));
  }
}

Result<RgbdFrame> Rawlog::convert(const Scan& scan, std::size_t index) {
  // MRPT keeps the folder of separately stored images in a global variable.
  static std::mutex mrpt_image_folder;
  const std::lock_guard lock(mrpt_image_folder);
  mrpt::img::CImage::setImagesPathBase(image_folder(file_).string());
  scan->load();

  RgbdFrame frame;
  frame.label = label(index);
  const bool stamped = scan->timestamp != INVALID_TIMESTAMP;
  frame.stamp_s = stamped ? mrpt::Clock::toDouble(scan->timestamp) : static_cast<double>(index) / 30.0;
  auto color = color_of(*scan);
  if (!color) return fail(color.error().code, label(index) + ": " + color.error().message);
  auto depth = aligner_.depth_of(*scan, color->size());
  if (!depth) return fail(depth.error().code, label(index) + ": " + depth.error().message);
  frame.color = *std::move(color);
  frame.depth = *std::move(depth);
  return frame;
}

}  // namespace

Result<std::unique_ptr<Recording>> open_rawlog(const fs::path& file) {
  auto rawlog = std::make_unique<Rawlog>(file);
  if (const auto indexed = rawlog->index(); !indexed) return tl::unexpected(indexed.error());
  return rawlog;
}

}  // namespace extperfc::sources

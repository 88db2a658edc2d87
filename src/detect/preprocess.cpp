#include "extperfc/detect/preprocess.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "detect/area_resize.hpp"
#include "detect/image_format.hpp"

namespace extperfc::detect {

namespace {

constexpr float kPadding = 114.0F;  // grey of the letterbox bars, as YOLO is trained with

/// Where the image goes in the input.
cv::Rect target_area(const InputSpec& spec, int width, int height) {
  if (spec.resize == Resize::kStretch) return {0, 0, spec.width, spec.height};
  const double scale =
      std::min(static_cast<double>(spec.width) / width, static_cast<double>(spec.height) / height);
  const int w = std::clamp(static_cast<int>(std::lround(width * scale)), 1, spec.width);
  const int h = std::clamp(static_cast<int>(std::lround(height * scale)), 1, spec.height);
  return {(spec.width - w) / 2, (spec.height - h) / 2, w, h};
}

/// From the area in whole pixels, so that boxes map back exactly.
Placement placement_of(const cv::Rect& area, int width, int height) {
  return {static_cast<float>(area.width) / static_cast<float>(width),
          static_cast<float>(area.height) / static_cast<float>(height), static_cast<float>(area.x),
          static_cast<float>(area.y)};
}

/// Fills what a letterbox leaves free of one plane.
void fill_around(cv::Mat& plane, const cv::Rect& area, float value) {
  plane.rowRange(0, area.y).setTo(value);
  plane.rowRange(area.br().y, plane.rows).setTo(value);
  plane(cv::Rect(0, area.y, area.x, area.height)).setTo(value);
  plane(cv::Rect(area.br().x, area.y, plane.cols - area.br().x, area.height)).setTo(value);
}

}  // namespace

Box2 Placement::to_image(const Box2& input_box) const {
  return {(input_box.x_min - offset_x) / scale_x, (input_box.y_min - offset_y) / scale_y,
          (input_box.x_max - offset_x) / scale_x, (input_box.y_max - offset_y) / scale_y};
}

/// Kept from image to image, so that nothing is allocated while the image's size stays.
struct Preprocessor::Scratch {
  cv::Mat colour;                   ///< full size, for formats that cannot be resized as they are
  cv::Mat small;                    ///< as large as the area it fills
  std::array<cv::Mat, 4> channels;  ///< of `small`
  AreaResizer area_resizer;

  void resize(const cv::Mat& image, int interpolation, std::array<AreaPlane, 3>& planes) {
    const cv::Size size = planes[0].pixels.size();
    if (interpolation == cv::INTER_AREA && AreaResizer::suits(image, size))
      return area_resizer.run(image, planes);
    cv::resize(image, small, size, 0, 0, interpolation);
    // For 320 x 256: cv::split and Mat::convertTo take 17 us, a table per channel 60, one plain fused
    // loop 68.
    if (small.channels() == 1)
      channels[0] = small;
    else
      cv::split(small, channels.data());
    for (AreaPlane& plane : planes)
      channels[static_cast<std::size_t>(plane.channel)].convertTo(plane.pixels, CV_32F, plane.scale,
                                                                  plane.offset);
  }
};

Preprocessor::Preprocessor(InputSpec spec) : spec_(std::move(spec)), scratch_(std::make_unique<Scratch>()) {}
Preprocessor::~Preprocessor() = default;
Preprocessor::Preprocessor(Preprocessor&&) noexcept = default;
Preprocessor& Preprocessor::operator=(Preprocessor&&) noexcept = default;

Result<Placement> Preprocessor::run(const ImageView& image, float* planes) try {
  if (const auto checked = check_image(image); !checked) return tl::unexpected(checked.error());
  const FormatTraits traits = traits_of(image.format);
  const cv::Rect area = target_area(spec_, image.width, image.height);
  const cv::Mat pixels = mat_around(image, traits);
  if (traits.conversion != kDirect) cv::cvtColor(pixels, scratch_->colour, traits.conversion);

  const double unit = traits.type == CV_16UC1 ? kMono16ToByte : 1.0;
  const std::size_t plane_size =
      static_cast<std::size_t>(spec_.width) * static_cast<std::size_t>(spec_.height);
  std::array<AreaPlane, 3> inside;
  for (std::size_t c = 0; c < 3; ++c) {
    cv::Mat plane(spec_.height, spec_.width, CV_32F, planes + c * plane_size);
    const float mean = spec_.mean[c];
    const float scale = spec_.scale[c];
    inside[c] = {plane(area), traits.channels[spec_.bgr ? 2 - c : c], unit * scale,
                 -static_cast<double>(mean) * scale};
    if (area.size() != plane.size()) fill_around(plane, area, (kPadding - mean) * scale);
  }
  scratch_->resize(traits.conversion == kDirect ? pixels : scratch_->colour,
                   spec_.interpolation == Interpolation::kArea ? cv::INTER_AREA : cv::INTER_LINEAR, inside);
  return placement_of(area, image.width, image.height);
} catch (const cv::Exception& error) {
  return fail(ErrorCode::kInvalidArgument, "cannot convert an image of " + std::to_string(image.width) +
                                               " x " + std::to_string(image.height) + " pixels, " +
                                               std::string(encoding_of(image.format)) + ": " + error.err);
}

}  // namespace extperfc::detect

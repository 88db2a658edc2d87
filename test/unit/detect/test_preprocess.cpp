#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "extperfc/base/rng.hpp"
#include "extperfc/detect/preprocess.hpp"

namespace extperfc::detect {
namespace {

InputSpec make_input(int width, int height, Resize resize) {
  InputSpec input;
  input.width = width;
  input.height = height;
  input.resize = resize;
  return input;
}

ImageView view(const cv::Mat& image, PixelFormat format) {
  return {image.data, image.cols, image.rows, image.step, format};
}

/// Slow change of colour, so that demosaicing and chroma subsampling lose little.
cv::Mat smooth_bgr(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(40 + 150 * x / width),
                                   static_cast<std::uint8_t>(60 + 120 * y / height),
                                   static_cast<std::uint8_t>(200 - 100 * x / width)};
  return image;
}

std::vector<float> run(const InputSpec& input, const ImageView& image) {
  std::vector<float> planes(static_cast<std::size_t>(3 * input.width * input.height), -1e9F);
  Preprocessor preprocessor(input);
  const auto placement = preprocessor.run(image, planes.data());
  EXPECT_TRUE(placement) << placement.error().message;
  return planes;
}

float largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
  float largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(Preprocessor, PlanesHaveTheNetworksChannelOrderMeanAndScale) {
  const cv::Mat image(6, 8, CV_8UC3, cv::Scalar(10, 20, 30));
  InputSpec input = make_input(8, 6, Resize::kStretch);
  input.mean = {1, 2, 3};
  input.scale = {0.5F, 2.0F, 4.0F};
  const auto rgb = run(input, view(image, PixelFormat::kBgr8));
  EXPECT_FLOAT_EQ(rgb[0], (30 - 1) * 0.5F);
  EXPECT_FLOAT_EQ(rgb[48], (20 - 2) * 2.0F);
  EXPECT_FLOAT_EQ(rgb[96], (10 - 3) * 4.0F);
  input.bgr = true;
  const auto bgr = run(input, view(image, PixelFormat::kBgr8));
  EXPECT_FLOAT_EQ(bgr[0], (10 - 1) * 0.5F);
  EXPECT_FLOAT_EQ(bgr[96], (30 - 3) * 4.0F);
}

TEST(Preprocessor, LetterboxFillsWithGreyAndCentres) {
  const cv::Mat image(10, 40, CV_8UC3, cv::Scalar::all(255));
  InputSpec input = make_input(20, 15, Resize::kLetterbox);
  input.mean = {100, 100, 100};
  input.scale = {0.1F, 0.1F, 0.1F};
  std::vector<float> planes(3 * 20 * 15);
  Preprocessor preprocessor(input);
  const Placement placement = preprocessor.run(view(image, PixelFormat::kRgb8), planes.data()).value();
  EXPECT_FLOAT_EQ(placement.offset_y, 5);
  EXPECT_FLOAT_EQ(placement.scale_x, 0.5F);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t y = 0; y < 15; ++y)
      for (std::size_t x = 0; x < 20; ++x)
        ASSERT_NEAR(planes[(c * 15 + y) * 20 + x], y < 5 || y >= 10 ? 1.4F : 15.5F, 1e-5F)
            << c << ' ' << x << ' ' << y;
}

// Whatever the sizes: the image's corners lie on whole input pixels, inside, and every box comes back.
TEST(Preprocessor, BoxesSurviveTheRoundTripThroughAnyLetterbox) {
  constexpr std::uint64_t kSeed = 1;
  Rng rng(kSeed);
  const cv::Mat canvas = cv::Mat::zeros(700, 1300, CV_8UC1);
  for (int i = 0; i < 300; ++i) {
    const InputSpec input = make_input(rng.integer(8, 160), rng.integer(8, 160),
                                       rng.chance(0.8) ? Resize::kLetterbox : Resize::kStretch);
    const cv::Mat image = canvas(cv::Rect(0, 0, rng.integer(1, 1300), rng.integer(1, 700)));
    std::vector<float> planes(static_cast<std::size_t>(3 * input.width * input.height));
    Preprocessor preprocessor(input);
    const Placement p = preprocessor.run(view(image, PixelFormat::kMono8), planes.data()).value();
    const auto w = static_cast<float>(image.cols);
    const auto h = static_cast<float>(image.rows);
    const Box2 in{p.offset_x, p.offset_y, w * p.scale_x + p.offset_x, h * p.scale_y + p.offset_y};
    EXPECT_NEAR(in.x_max, std::round(in.x_max), 1e-3F);
    EXPECT_NEAR(in.y_max, std::round(in.y_max), 1e-3F);
    EXPECT_LE(in.x_max, static_cast<float>(input.width) + 1e-3F);
    EXPECT_LE(in.y_max, static_cast<float>(input.height) + 1e-3F);
    const Box2 out = p.to_image(in);
    EXPECT_NEAR(out.x_min, 0, 1e-3F) << "round " << i << " of seed " << kSeed;
    EXPECT_NEAR(out.y_min, 0, 1e-3F);
    EXPECT_NEAR(out.x_max, w, 1e-3F * w);
    EXPECT_NEAR(out.y_max, h, 1e-3F * h);
  }
}

TEST(Preprocessor, EveryFormatGivesTheSameInputForTheSameImage) {
  const cv::Mat bgr = smooth_bgr(64, 48);
  const InputSpec input = make_input(40, 40, Resize::kLetterbox);
  const auto expected = run(input, view(bgr, PixelFormat::kBgr8));
  const auto difference = [&](int code, PixelFormat format) {
    cv::Mat converted;
    cv::cvtColor(bgr, converted, code);
    return largest_difference(expected, run(input, view(converted, format)));
  };
  EXPECT_EQ(difference(cv::COLOR_BGR2RGB, PixelFormat::kRgb8), 0);
  EXPECT_EQ(difference(cv::COLOR_BGR2RGBA, PixelFormat::kRgba8), 0);
  EXPECT_EQ(difference(cv::COLOR_BGR2BGRA, PixelFormat::kBgra8), 0);
}

TEST(Preprocessor, InterpolationsAgreeOnASmoothImage) {
  const cv::Mat bgr = smooth_bgr(64, 48);
  InputSpec input = make_input(40, 30, Resize::kStretch);
  const auto linear = run(input, view(bgr, PixelFormat::kBgr8));
  input.interpolation = Interpolation::kArea;
  EXPECT_LT(largest_difference(linear, run(input, view(bgr, PixelFormat::kBgr8))), 5);
}

TEST(Preprocessor, BayerPatternsAreTheRosOnes) {
  const cv::Mat bgr = smooth_bgr(64, 48);
  const InputSpec input = make_input(32, 24, Resize::kStretch);
  const auto expected = run(input, view(bgr, PixelFormat::kBgr8));
  // Channel (in BGR order) of the first 2 x 2 pixels.
  const std::vector<std::pair<PixelFormat, std::array<int, 4>>> patterns{
      {PixelFormat::kBayerRggb8, {2, 1, 1, 0}},
      {PixelFormat::kBayerBggr8, {0, 1, 1, 2}},
      {PixelFormat::kBayerGbrg8, {1, 0, 2, 1}},
      {PixelFormat::kBayerGrbg8, {1, 2, 0, 1}}};
  for (const auto& [format, channels] : patterns) {
    cv::Mat raw(bgr.size(), CV_8UC1);
    for (int y = 0; y < raw.rows; ++y)
      for (int x = 0; x < raw.cols; ++x)
        raw.at<std::uint8_t>(y, x) =
            bgr.at<cv::Vec3b>(y, x)[channels[static_cast<std::size_t>(2 * (y % 2) + x % 2)]];
    EXPECT_LT(largest_difference(expected, run(input, view(raw, format))), 8) << encoding_of(format);
  }
}

TEST(Preprocessor, Yuv422InBothByteOrders) {
  const cv::Mat bgr = smooth_bgr(64, 48);
  const InputSpec input = make_input(32, 24, Resize::kStretch);
  const auto expected = run(input, view(bgr, PixelFormat::kBgr8));
  cv::Mat uyvy(bgr.size(), CV_8UC2);
  cv::Mat yuy2(bgr.size(), CV_8UC2);
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      // ITU-R BT.601, studio range.
      const cv::Vec3b& p = bgr.at<cv::Vec3b>(y, x);
      const double luma = 16 + 0.257 * p[2] + 0.504 * p[1] + 0.098 * p[0];
      const double chroma = x % 2 == 0 ? 128 - 0.148 * p[2] - 0.291 * p[1] + 0.439 * p[0]
                                       : 128 + 0.439 * p[2] - 0.368 * p[1] - 0.071 * p[0];
      uyvy.at<cv::Vec2b>(y, x) = {cv::saturate_cast<std::uint8_t>(chroma),
                                  cv::saturate_cast<std::uint8_t>(luma)};
      yuy2.at<cv::Vec2b>(y, x) = {cv::saturate_cast<std::uint8_t>(luma),
                                  cv::saturate_cast<std::uint8_t>(chroma)};
    }
  EXPECT_LT(largest_difference(expected, run(input, view(uyvy, PixelFormat::kYuv422))), 8);
  EXPECT_LT(largest_difference(expected, run(input, view(yuy2, PixelFormat::kYuv422Yuy2))), 8);
}

TEST(Preprocessor, GreyOfEightAndSixteenBitsFillsAllChannels) {
  cv::Mat grey;
  cv::cvtColor(smooth_bgr(64, 48), grey, cv::COLOR_BGR2GRAY);
  cv::Mat three;
  cv::cvtColor(grey, three, cv::COLOR_GRAY2BGR);
  cv::Mat wide;
  grey.convertTo(wide, CV_16U, 257);
  const InputSpec input = make_input(20, 30, Resize::kLetterbox);
  const auto expected = run(input, view(three, PixelFormat::kBgr8));
  EXPECT_EQ(largest_difference(expected, run(input, view(grey, PixelFormat::kMono8))), 0);
  EXPECT_LT(largest_difference(expected, run(input, view(wide, PixelFormat::kMono16))), 1);
}

TEST(Preprocessor, RowsMayBePadded) {
  const cv::Mat wide = smooth_bgr(64, 48);
  const cv::Mat part = wide(cv::Rect(8, 8, 32, 24));
  const InputSpec input = make_input(16, 12, Resize::kStretch);
  EXPECT_EQ(run(input, view(part, PixelFormat::kBgr8)), run(input, view(part.clone(), PixelFormat::kBgr8)));
}

TEST(Preprocessor, OnePreprocessorTakesImagesOfChangingSizeAndFormat) {
  const InputSpec input = make_input(20, 30, Resize::kLetterbox);
  Preprocessor preprocessor(input);
  std::vector<float> planes(3 * 20 * 30);
  const cv::Mat colour = smooth_bgr(64, 48);
  const cv::Mat grey(100, 30, CV_8UC1, cv::Scalar(9));
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(preprocessor.run(view(grey, PixelFormat::kMono8), planes.data()));
    ASSERT_TRUE(preprocessor.run(view(colour, PixelFormat::kBgr8), planes.data()));
    EXPECT_EQ(planes, run(input, view(colour, PixelFormat::kBgr8)));
  }
}

TEST(Preprocessor, RefusesWhatIsNoColourImage) {
  Preprocessor preprocessor(make_input(8, 6, Resize::kStretch));
  std::vector<float> planes(3 * 8 * 6);
  EXPECT_EQ(preprocessor.run({}, planes.data()).error().code, ErrorCode::kInvalidArgument);
  const cv::Mat depth = cv::Mat::zeros(6, 8, CV_32F);
  for (const auto format : {PixelFormat::kDepth16Mm, PixelFormat::kDepth32M})
    EXPECT_EQ(preprocessor.run(view(depth, format), planes.data()).error().code, ErrorCode::kUnsupported);
  ImageView narrow = view(depth, PixelFormat::kRgb8);
  narrow.row_bytes = 23;
  const auto error = preprocessor.run(narrow, planes.data()).error();
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument);
  EXPECT_NE(error.message.find("24 bytes"), std::string::npos) << error.message;
}

}  // namespace
}  // namespace extperfc::detect

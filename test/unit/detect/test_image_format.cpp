// Whole images as BGR.
#include <vector>

#include <gtest/gtest.h>

#include "detect/image_format.hpp"

namespace extperfc::detect {
namespace {

/// 2 x 2 pixels of one colour in each format that a camera may send.
struct Sample {
  PixelFormat format;
  std::vector<std::uint8_t> pixels;
};

ImageView view_of(const Sample& sample) {
  return {sample.pixels.data(), 2, 2, 2 * bytes_per_pixel(sample.format), sample.format};
}

std::vector<std::uint8_t> repeated(const std::vector<std::uint8_t>& pixel) {
  std::vector<std::uint8_t> all;
  for (int i = 0; i < 4; ++i) all.insert(all.end(), pixel.begin(), pixel.end());
  return all;
}

TEST(BgrImage, EveryFormatGivesTheSameColour) {
  for (const Sample& sample : {Sample{PixelFormat::kRgb8, repeated({200, 100, 50})},
                               Sample{PixelFormat::kBgr8, repeated({50, 100, 200})},
                               Sample{PixelFormat::kRgba8, repeated({200, 100, 50, 9})},
                               Sample{PixelFormat::kBgra8, repeated({50, 100, 200, 9})}}) {
    const auto image = bgr_image(view_of(sample));
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->at<cv::Vec3b>(1, 1), cv::Vec3b(50, 100, 200)) << encoding_of(sample.format);
  }
}

TEST(BgrImage, GreyBecomesThreeChannels) {
  for (const Sample& sample :
       {Sample{PixelFormat::kMono8, repeated({77})}, Sample{PixelFormat::kMono16, repeated({77, 77})}}) {
    const auto image = bgr_image(view_of(sample));
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(image->at<cv::Vec3b>(0, 1), cv::Vec3b(77, 77, 77)) << encoding_of(sample.format);
  }
}

TEST(BgrImage, WhatIsNoColourImageIsAnError) {
  EXPECT_EQ(bgr_image({}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(bgr_image(view_of({PixelFormat::kDepth16Mm, repeated({1, 1})})).error().code,
            ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace extperfc::detect

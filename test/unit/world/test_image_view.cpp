#include <gtest/gtest.h>

#include "extperfc/world/detection.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc {
namespace {

TEST(PixelFormat, EncodingAndBackIsTheSame) {
  for (int i = 0; i <= static_cast<int>(PixelFormat::kDepth32M); ++i) {
    const auto format = static_cast<PixelFormat>(i);
    EXPECT_EQ(pixel_format_from_encoding(encoding_of(format)), format) << encoding_of(format);
    EXPECT_GE(bytes_per_pixel(format), 1U);
  }
}

TEST(PixelFormat, UnknownEncodingIsNothing) {
  EXPECT_EQ(pixel_format_from_encoding("jpeg"), std::nullopt);
}

TEST(Box2, IntersectionOverUnion) {
  const Box2 a{0, 0, 10, 10};
  EXPECT_FLOAT_EQ(iou(a, a), 1.0F);
  EXPECT_FLOAT_EQ(iou(a, {5, 0, 15, 10}), 50.0F / 150.0F);
  EXPECT_FLOAT_EQ(iou(a, {10, 10, 20, 20}), 0.0F);
  EXPECT_FLOAT_EQ(iou({0, 0, 0, 0}, {0, 0, 0, 0}), 0.0F);
}

}  // namespace
}  // namespace extperfc

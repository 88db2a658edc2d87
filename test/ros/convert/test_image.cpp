#include <limits>

#include <boost/make_shared.hpp>
#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include "ros/convert/image.hpp"

namespace extperfc::ros_convert {
namespace {

sensor_msgs::ImagePtr image(const std::string& encoding, std::uint32_t width, std::uint32_t height,
                            std::uint32_t pixel_bytes) {
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->encoding = encoding;
  message->width = width;
  message->height = height;
  message->step = width * pixel_bytes;
  message->data.resize(static_cast<std::size_t>(message->step) * height);
  return message;
}

struct Known {
  const char* encoding;
  std::uint32_t pixel_bytes;
  PixelFormat format;
};

class KnownEncoding : public testing::TestWithParam<Known> {};

TEST_P(KnownEncoding, IsSharedWithoutACopy) {
  const auto message = image(GetParam().encoding, 6, 4, GetParam().pixel_bytes);
  const auto shared = share_image(message);
  ASSERT_TRUE(shared) << shared.error().message;
  EXPECT_EQ(shared->view.data, message->data.data());
  EXPECT_EQ(shared->view.width, 6);
  EXPECT_EQ(shared->view.height, 4);
  EXPECT_EQ(shared->view.row_bytes, message->step);
  EXPECT_EQ(shared->view.format, GetParam().format);
}

TEST_P(KnownEncoding, OneMissingByteIsNoticed) {
  const auto message = image(GetParam().encoding, 6, 4, GetParam().pixel_bytes);
  message->data.pop_back();
  const auto shared = share_image(message);
  ASSERT_FALSE(shared);
  EXPECT_EQ(shared.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(shared.error().message.find(std::to_string(message->data.size())), std::string::npos)
      << shared.error().message;
}

INSTANTIATE_TEST_SUITE_P(
    All, KnownEncoding,
    testing::Values(
        Known{"rgb8", 3, PixelFormat::kRgb8}, Known{"bgr8", 3, PixelFormat::kBgr8},
        Known{"rgba8", 4, PixelFormat::kRgba8}, Known{"bgra8", 4, PixelFormat::kBgra8},
        Known{"mono8", 1, PixelFormat::kMono8}, Known{"mono16", 2, PixelFormat::kMono16},
        Known{"bayer_rggb8", 1, PixelFormat::kBayerRggb8}, Known{"bayer_bggr8", 1, PixelFormat::kBayerBggr8},
        Known{"bayer_gbrg8", 1, PixelFormat::kBayerGbrg8}, Known{"bayer_grbg8", 1, PixelFormat::kBayerGrbg8},
        Known{"yuv422", 2, PixelFormat::kYuv422}, Known{"yuv422_yuy2", 2, PixelFormat::kYuv422Yuy2},
        Known{"16UC1", 2, PixelFormat::kDepth16Mm}, Known{"32FC1", 4, PixelFormat::kDepth32M}),
    [](const auto& test) { return std::string("encoding_") + test.param.encoding; });

TEST(ShareImage, KeepsTheMessageAlive) {
  auto message = image("mono8", 6, 4, 1);
  message->data[0] = 77;
  auto shared = share_image(message);
  ASSERT_TRUE(shared);
  message.reset();
  EXPECT_EQ(shared->view.data[0], 77);
}

TEST(ShareImage, UnknownEncodingIsNamedWithThoseThatAreKnown) {
  for (const char* encoding : {"jpeg", "", "rgb16", "32FC3", "RGB8"}) {
    const auto shared = share_image(image(encoding, 6, 4, 3));
    ASSERT_FALSE(shared) << encoding;
    EXPECT_EQ(shared.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(shared.error().message.find("'" + std::string(encoding) + "'"), std::string::npos);
    EXPECT_NE(shared.error().message.find("bgr8"), std::string::npos);
  }
}

TEST(ShareImage, EmptyImagesAreRefused) {
  EXPECT_FALSE(share_image(image("rgb8", 0, 4, 3)));
  EXPECT_FALSE(share_image(image("rgb8", 6, 0, 3)));
  EXPECT_FALSE(share_image(boost::make_shared<sensor_msgs::Image>()));
}

TEST(ShareImage, SizesThatWouldOverflowAreRefused) {
  auto message = image("rgb8", 6, 4, 3);
  message->width = std::numeric_limits<std::uint32_t>::max();
  EXPECT_FALSE(share_image(message));
  message = image("rgb8", 6, 4, 3);
  message->height = std::numeric_limits<std::uint32_t>::max();
  EXPECT_FALSE(share_image(message));
  message = image("rgb8", 6, 4, 3);
  message->step = std::numeric_limits<std::uint32_t>::max();
  EXPECT_FALSE(share_image(message));
}

TEST(ShareImage, PaddedRowsAreUnderstood) {
  auto message = image("rgb8", 6, 4, 3);
  message->step = 32;
  message->data.resize(32 * 4);
  const auto shared = share_image(message);
  ASSERT_TRUE(shared);
  EXPECT_EQ(shared->view.row(1), message->data.data() + 32);
}

TEST(ShareImage, BigEndianDepthIsTurned) {
  auto message = image("16UC1", 2, 1, 2);
  message->is_bigendian = 1;
  message->data = {0x03, 0xE8, 0x00, 0x00};  // 1000 mm, no measurement
  const auto shared = share_image(message);
  ASSERT_TRUE(shared) << shared.error().message;
  EXPECT_EQ(reinterpret_cast<const std::uint16_t*>(shared->view.data)[0], 1000);
}

CameraModel some_camera() {
  return {640, 480, 610.5, 611.5, 319.0, 241.0, {0.1, -0.2, 0.001, -0.002, 0.05}};
}

TEST(CameraInfo, ThereAndBackAgain) {
  std_msgs::Header header;
  header.frame_id = "optical";
  header.stamp = ros::Time(12, 34);
  const auto info = to_camera_info(some_camera(), header);
  EXPECT_EQ(info.header.frame_id, "optical");
  EXPECT_EQ(info.header.stamp, ros::Time(12, 34));
  const auto camera = to_camera_model(info);
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(camera->width, 640);
  EXPECT_EQ(camera->height, 480);
  EXPECT_EQ(camera->fx, 610.5);
  EXPECT_EQ(camera->fy, 611.5);
  EXPECT_EQ(camera->cx, 319.0);
  EXPECT_EQ(camera->cy, 241.0);
  EXPECT_EQ(camera->distortion, some_camera().distortion);
  EXPECT_EQ(info.P[0], 610.5);
  EXPECT_EQ(info.P[6], 241.0);
  EXPECT_EQ(info.R[8], 1.0);
}

TEST(CameraInfo, DistortionThatIsNotPlumbBobIsRefusedUnlessZero) {
  auto info = to_camera_info(some_camera(), {});
  info.distortion_model = "equidistant";
  const auto refused = to_camera_model(info);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(refused.error().message.find("'equidistant'"), std::string::npos);
  info.D.assign(4, 0.0);
  EXPECT_TRUE(to_camera_model(info)) << "without distortion the model does not matter";
}

TEST(CameraInfo, CoefficientsMayBeFewerButNotMore) {
  auto info = to_camera_info(some_camera(), {});
  info.D = {0.1, -0.2};
  const auto camera = to_camera_model(info);
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->distortion, (std::array<double, 5>{0.1, -0.2, 0, 0, 0}));
  info.D.assign(8, 0.01);
  EXPECT_FALSE(to_camera_model(info));
  info.D.clear();
  EXPECT_TRUE(to_camera_model(info));
  info.D.assign(8, 0.0);
  info.distortion_model = "rational_polynomial";
  EXPECT_TRUE(to_camera_model(info));
}

TEST(CameraInfo, OneThatIsNotCalibratedIsRefused) {
  auto info = to_camera_info(some_camera(), {});
  info.K.fill(0.0);
  EXPECT_FALSE(to_camera_model(info));
  info = to_camera_info(some_camera(), {});
  info.K[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(to_camera_model(info));
  info = to_camera_info(some_camera(), {});
  info.width = 0;
  EXPECT_FALSE(to_camera_model(info));
}

}  // namespace
}  // namespace extperfc::ros_convert

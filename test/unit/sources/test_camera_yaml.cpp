#include <string>

#include <gtest/gtest.h>

#include "extperfc/sources/recording.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::sources {
namespace {

/// What camera_calibration writes, with the parts that tests exchange.
std::string yaml(const std::string& model = "plumb_bob",
                 const std::string& coefficients = "0.1, -0.2, 0.001, 0.002, 0.03",
                 const std::string& k = "518, 0, 325.5, 0, 519, 253.5, 0, 0, 1") {
  return "image_width: 640\nimage_height: 480\ncamera_name: kinect\n"
         "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [" +
         k +
         "]\n"
         "distortion_model: " +
         model +
         "\n"
         "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [" +
         coefficients + "]\n";
}

Result<CameraModel> load(const std::string& text) {
  const TemporaryFolder folder;
  return load_camera_yaml(folder.write("camera_info.yaml", text));
}

TEST(CameraYaml, ReadsWhatCameraCalibrationWrites) {
  const auto camera = load(yaml());
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ(camera->width, 640);
  EXPECT_EQ(camera->height, 480);
  EXPECT_DOUBLE_EQ(camera->fx, 518.0);
  EXPECT_DOUBLE_EQ(camera->fy, 519.0);
  EXPECT_DOUBLE_EQ(camera->cx, 325.5);
  EXPECT_DOUBLE_EQ(camera->cy, 253.5);
  EXPECT_DOUBLE_EQ(camera->distortion[4], 0.03);
}

TEST(CameraYaml, DistortionIsOptional) {
  const auto camera = load(
      "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, "
      "240, 0, 0, 1]}\n");
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_DOUBLE_EQ(camera->distortion[0], 0.0);
}

TEST(CameraYaml, OtherLensModelsAreRefusedUnlessTheyDoNothing) {
  EXPECT_TRUE(load(yaml("rational_polynomial", "0, 0, 0, 0, 0, 0, 0, 0")));
  const auto fisheye = load(yaml("equidistant", "0.1, 0, 0, 0"));
  ASSERT_FALSE(fisheye);
  EXPECT_EQ(fisheye.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(fisheye.error().message.find("equidistant"), std::string::npos);
  EXPECT_FALSE(load(yaml("plumb_bob", "0.1, 0, 0, 0, 0, 0.5, 0, 0")));
}

TEST(CameraYaml, ErrorsNameTheFileAndTheProblem) {
  EXPECT_EQ(load_camera_yaml("/no/such/camera.yaml").error().code, ErrorCode::kNotFound);
  for (const auto& text :
       {std::string("image_width: [unclosed"), std::string("just text"), std::string(),
        std::string("image_width: wide\n"), yaml("plumb_bob", "a, b"), yaml("plumb_bob", "0", "1, 2")}) {
    const auto camera = load(text);
    ASSERT_FALSE(camera) << text;
    EXPECT_EQ(camera.error().code, ErrorCode::kCorrupt) << text;
    EXPECT_NE(camera.error().message.find("camera_info.yaml"), std::string::npos);
  }
  const auto uncalibrated = load(yaml("plumb_bob", "0, 0, 0, 0, 0", "0, 0, 0, 0, 0, 0, 0, 0, 0"));
  ASSERT_FALSE(uncalibrated);
  EXPECT_NE(uncalibrated.error().message.find("fx"), std::string::npos);
}

}  // namespace
}  // namespace extperfc::sources

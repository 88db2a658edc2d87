#include <cmath>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/world/camera_model.hpp"

namespace extperfc {
namespace {

CameraModel kinect() {
  return {640, 480, 518.0, 519.0, 325.5, 253.5, {}};
}

TEST(CameraModel, PrincipalPointLooksStraightAhead) {
  const auto p = kinect().back_project(325.5, 253.5, 2.0);
  EXPECT_DOUBLE_EQ(p.x(), 0.0);
  EXPECT_DOUBLE_EQ(p.y(), 0.0);
  EXPECT_DOUBLE_EQ(p.z(), 2.0);
}

TEST(CameraModel, OneFocalLengthToTheRightIs45Degrees) {
  const auto p = kinect().back_project(325.5 + 518.0, 253.5, 1.5);
  EXPECT_NEAR(p.x(), 1.5, 1e-12);
}

TEST(CameraModel, ProjectUndoesBackProject) {
  Rng rng(7);
  for (int i = 0; i < 500; ++i) {
    auto camera = kinect();
    camera.distortion = {rng.uniform(-0.15, 0.1), rng.uniform(-0.05, 0.05), rng.uniform(-2e-3, 2e-3),
                         rng.uniform(-2e-3, 2e-3), rng.uniform(-0.01, 0.01)};
    const double u = rng.uniform(0, 640);
    const double v = rng.uniform(0, 480);
    const auto back = camera.project(camera.back_project(u, v, rng.uniform(0.2, 8.0)));
    EXPECT_NEAR(back.x(), u, 1e-3) << "seed 7, case " << i;
    EXPECT_NEAR(back.y(), v, 1e-3) << "seed 7, case " << i;
  }
}

TEST(CameraModel, ValidateNamesWhatIsWrong) {
  EXPECT_TRUE(kinect().validate());
  auto uncalibrated = kinect();
  uncalibrated.fx = 0.0;
  ASSERT_FALSE(uncalibrated.validate());
  EXPECT_NE(uncalibrated.validate().error().message.find("fx"), std::string::npos);
  auto empty = kinect();
  empty.width = 0;
  EXPECT_FALSE(empty.validate());
  auto broken = kinect();
  broken.distortion[2] = std::nan("");
  EXPECT_FALSE(broken.validate());
}

}  // namespace
}  // namespace extperfc

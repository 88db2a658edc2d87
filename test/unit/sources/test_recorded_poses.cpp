#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "sources/recorded_poses.hpp"

namespace extperfc::sources {
namespace {

std::filesystem::path write_poses(const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() / "extperfc_poses.txt";
  std::ofstream(file) << text;
  return file;
}

TEST(RecordedPoses, ExactInterpolatedAndOutside) {
  // A rotation by 90 degrees about z while moving 1 m along x.
  const auto poses = RecordedPoses::load(write_poses(
      "# comment\n10.0 0 0 1 0 0 0 1\n10.2 1 0 1 0 0 0.70710678 0.70710678\n20.0 5 0 1 0 0 0 1\n"));
  ASSERT_TRUE(poses);
  EXPECT_TRUE(poses->at(10.2)->translation().isApprox(Eigen::Vector3d(1, 0, 1)));
  const auto middle = poses->at(10.1);
  ASSERT_TRUE(middle);
  EXPECT_TRUE(middle->translation().isApprox(Eigen::Vector3d(0.5, 0, 1)));
  const Eigen::AngleAxisd rotation(middle->rotation());
  EXPECT_NEAR(rotation.angle(), 0.25 * 3.14159265358979, 1e-6);
  EXPECT_FALSE(poses->at(9.9));
  EXPECT_FALSE(poses->at(15.0)) << "a gap of 9.8 s";
  EXPECT_FALSE(poses->at(20.1));
}

TEST(RecordedPoses, ErrorsNameFileAndLine) {
  const auto broken = RecordedPoses::load(write_poses("10.0 0 0 1 0 0 0 1\n10.1 0 0\n"));
  ASSERT_FALSE(broken);
  EXPECT_NE(broken.error().message.find("line 2"), std::string::npos);
  EXPECT_FALSE(RecordedPoses::load(write_poses("1.0 0 0 0 0 0 0 0.5\n")));
  EXPECT_FALSE(RecordedPoses::load("/no/such/file"));
}

}  // namespace
}  // namespace extperfc::sources

// What rosbag records, rosbag plays to the detector, round and round: time that goes back stops nothing.
#include <set>

#include <gtest/gtest.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <vision_msgs/Detection3DArray.h>

#include "test/ros/support/child_process.hpp"
#include "test/ros/support/images.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/recording.hpp"
#include "test/ros/support/watch.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

constexpr int kFrames = 16;
constexpr double kFirstStampS = 100.0;  // of write_tum_recording
constexpr double kPeriodS = 0.1;
constexpr double kLastStampS = kFirstStampS + kPeriodS * (kFrames - 1);

class RosbagTest : public testing::Test {
 protected:
  /// Plays a recording with its own stamps to `rosbag record`, which ends by itself.
  void record() {
    write_tum_recording(folder_.path(), kFrames);
    ChildProcess recorder(
        {"rosbag", "record", "-O", bag(), "-l", std::to_string(kFrames), kColor, kDepth, kInfo});
    Manager manager;
    ASSERT_TRUE(manager.load("/source", "image_pair_source",
                             {{"path", folder_.path().string()},
                              {"rate_hz", 10.0},
                              {"recorded_stamps", true},
                              {"depth_scale", 5000.0}}));
    ASSERT_EQ(recorder.wait_for_end(), 0);
  }

  void load() {
    ASSERT_TRUE(manager_.load("/detector", "detector", detector_params()));
    ASSERT_TRUE(manager_.load("/box_depth", "box_depth", {}));
    ASSERT_TRUE(wait_for([this] { return objects_.connected(); }));
  }

  [[nodiscard]] std::string bag() const { return (folder_.path() / "recorded.bag").string(); }

  /// How often the stamps of the results went back.
  [[nodiscard]] int rounds() const {
    int backwards = 0;
    const auto all = objects_.all();
    for (std::size_t i = 1; i < all.size(); ++i)
      if (all[i]->header.stamp < all[i - 1]->header.stamp) ++backwards;
    return backwards;
  }

  static constexpr const char* kColor = "/camera/color/image_raw";
  static constexpr const char* kDepth = "/camera/aligned_depth_to_color/image_raw";
  static constexpr const char* kInfo = "/camera/color/camera_info";
  TemporaryFolder folder_;
  Inbox<vision_msgs::Detection3DArray> objects_{"detections_3d"};
  Inbox<vision_msgs::Detection3DArray> surface_{"detections_3d/surface"};
  DiagnosticsWatch detector_{"detector"};
  DiagnosticsWatch depth_{"box_depth"};
  LogWatch log_;
  Manager manager_;
};

/// With the clock that `rosbag play --clock` publishes or without, it must be the same. Nobody here uses
/// simulated time.
class RosbagClockTest : public RosbagTest, public testing::WithParamInterface<bool> {};

TEST_P(RosbagClockTest, ALoopedBagIsDetectedAgainAndAgain) {
  ASSERT_NO_FATAL_FAILURE(record());
  load();
  std::vector<std::string> command{"rosbag", "play", "--loop", "--quiet", bag()};
  if (GetParam()) command.emplace_back("--clock");
  ChildProcess player(command);
  ASSERT_TRUE(wait_for([this] { return rounds() >= 2; }))
      << objects_.count() << " results; player runs: " << player.running() << "\n"
      << log_.text() << depth_.latest().message();
  std::set<double> stamps;
  for (const auto& message : objects_.all()) {
    const double stamp_s = message->header.stamp.toSec();
    stamps.insert(stamp_s);
    EXPECT_GE(stamp_s, kFirstStampS - 1e-6);
    EXPECT_LE(stamp_s, kLastStampS + 1e-6);
    ASSERT_EQ(message->detections.size(), 1U);
    const auto& object = message->detections.front();
    EXPECT_EQ(object.results.front().pose.pose, object.bbox.center);
    EXPECT_NEAR(object.bbox.center.position.z, 1.0 + 0.5 * object.bbox.size.z, 0.02);
  }
  EXPECT_GT(surface_.count(), static_cast<std::size_t>(kFrames / 2));
  for (const auto& message : surface_.all()) {
    ASSERT_EQ(message->detections.size(), 1U);
    EXPECT_NEAR(message->detections.front().results.front().pose.pose.position.z, 1.0, 0.01);
  }
  EXPECT_GT(stamps.size(), static_cast<std::size_t>(kFrames / 2)) << "most frames are answered";
  EXPECT_EQ(detector_.latest().value("image transport"), "network");
  EXPECT_EQ(detector_.latest().number("failed"), 0);
  EXPECT_EQ(depth_.latest().number("failed"), 0) << log_.text();
}

INSTANTIATE_TEST_SUITE_P(All, RosbagClockTest, testing::Bool(),
                         [](const auto& test) { return test.param ? "with_clock" : "without_clock"; });

}  // namespace
}  // namespace extperfc::ros_test

// Images travel as pointers inside one manager: the address that a subscriber reads from is the one that
// the publisher wrote to. From another process they come through a socket, and diagnostics say so.
#include <gtest/gtest.h>
#include <vision_msgs/Detection2DArray.h>
#include <vision_msgs/Detection3DArray.h>

#include "test/ros/support/images.hpp"
#include "test/ros/support/inbox.hpp"
#include "test/ros/support/manager.hpp"
#include "test/ros/support/recording.hpp"
#include "test/ros/support/watch.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

constexpr std::size_t kFrames = 20;
// Diagnostics sample the frames: on a busy machine many a frame passes between two samples.
constexpr double kSamplingPatienceS = 60.0;
constexpr const char* kPointer = "pointer (no copy)";
using Addresses = std::map<std::string, std::string>;

/// Stamps that both sides know.
std::size_t shared_stamps(const Addresses& a, const Addresses& b) {
  std::size_t shared = 0;
  for (const auto& entry : a) shared += b.count(entry.first);
  return shared;
}

void expect_same_addresses(const Addresses& published, const Addresses& received, const std::string& by) {
  for (const auto& [stamp, address] : received)
    if (const auto found = published.find(stamp); found != published.end()) {
      EXPECT_EQ(address, found->second) << by << " read a copy of the image of " << stamp;
    }
}

Addresses addresses_of(const Inbox<sensor_msgs::Image>& inbox) {
  Addresses addresses;
  for (const auto& image : inbox.all())
    addresses[stamp_text(image->header.stamp)] = address_text(image->data.data());
  return addresses;
}

TEST(ZeroCopy, DetectorReadsTheImageWhereThisTestPutIt) {
  Manager manager;
  const DiagnosticsWatch detector("detector");
  auto publisher = ros::NodeHandle().advertise<sensor_msgs::Image>("camera/color/image_raw", 2);
  const Inbox<vision_msgs::Detection2DArray> detections("detections");
  ASSERT_TRUE(manager.load("/detector", "detector", detector_params()));
  ASSERT_TRUE(wait_for([&] { return publisher.getNumSubscribers() > 0 && detections.connected(); }));

  std::vector<sensor_msgs::ImageConstPtr> kept;  // so that no address is used twice
  for (std::size_t i = 0; i < kFrames; ++i) {
    kept.push_back(to_image(draw_square(kRed), "bgr8", ros::Time::now()));
    publisher.publish(kept.back());
    const auto expected =
        stamp_text(kept.back()->header.stamp) + " @ " + address_text(kept.back()->data.data());
    ASSERT_TRUE(detector.wait_latest([&](const Report& r) { return r.value("image last") == expected; }))
        << "wanted " << expected << ", the detector says " << detector.latest().value("image last");
  }
  EXPECT_EQ(detector.latest().value("image transport"), kPointer);
}

TEST(ZeroCopy, OneImageForSourceDetectorDepthAndThisTest) {
  TemporaryFolder folder;
  write_recording(folder.path(), 4);
  Manager manager;
  const DiagnosticsWatch source("source");
  const DiagnosticsWatch detector("detector");
  const DiagnosticsWatch depth("box_depth");
  const Inbox<sensor_msgs::Image> color_images("camera/color/image_raw");
  const Inbox<sensor_msgs::Image> depth_images("camera/aligned_depth_to_color/image_raw");
  const Inbox<vision_msgs::Detection3DArray> objects("detections_3d");
  ASSERT_TRUE(manager.load("/detector", "detector", detector_params()));
  ASSERT_TRUE(manager.load("/box_depth", "box_depth", {}));
  // Diagnostics come five times a second, so at this rate hardly a frame is missing in them.
  ASSERT_TRUE(
      manager.load("/source", "image_pair_source", {{"path", folder.path().string()}, {"rate_hz", 4.0}}));

  const auto enough = [&] {
    const auto color = addresses_of(color_images);
    const auto aligned = addresses_of(depth_images);
    return shared_stamps(color, detector.addresses("image last")) >= kFrames &&
           shared_stamps(color, source.addresses("color last")) >= kFrames &&
           shared_stamps(aligned, depth.addresses("depth last")) >= kFrames &&
           shared_stamps(aligned, source.addresses("depth last")) >= kFrames;
  };
  ASSERT_TRUE(wait_for(enough, kSamplingPatienceS))
      << color_images.count() << " images, " << objects.count() << " results";
  expect_same_addresses(addresses_of(color_images), detector.addresses("image last"), "detector");
  expect_same_addresses(addresses_of(color_images), source.addresses("color last"), "source");
  expect_same_addresses(addresses_of(depth_images), depth.addresses("depth last"), "box_depth");
  expect_same_addresses(addresses_of(depth_images), source.addresses("depth last"), "source");
  EXPECT_EQ(detector.latest().value("image transport"), kPointer);
  EXPECT_EQ(depth.latest().value("depth transport"), kPointer);
  EXPECT_EQ(depth.latest().value("detections transport"), kPointer);
}

/// What zero_copy.test starts in the namespaces /near and /far, with a real nodelet manager.
struct Robot {
  explicit Robot(const std::string& ns)
      : source(ns + "/source"),
        detector(ns + "/detector"),
        depth(ns + "/box_depth"),
        objects("/" + ns + "/detections_3d") {}
  DiagnosticsWatch source;
  DiagnosticsWatch detector;
  DiagnosticsWatch depth;
  Inbox<vision_msgs::Detection3DArray> objects;

  [[nodiscard]] bool wait_for_frames(std::size_t count) const {
    return wait_for(
        [&] {
          return shared_stamps(source.addresses("color last"), detector.addresses("image last")) >= count &&
                 shared_stamps(source.addresses("depth last"), depth.addresses("depth last")) >= count;
        },
        kSamplingPatienceS);
  }
};

TEST(ZeroCopy, HoldsInARealManager) {
  const Robot robot("near");
  ASSERT_TRUE(robot.wait_for_frames(kFrames)) << robot.objects.count() << " results";
  expect_same_addresses(robot.source.addresses("color last"), robot.detector.addresses("image last"),
                        "detector");
  expect_same_addresses(robot.source.addresses("depth last"), robot.depth.addresses("depth last"),
                        "box_depth");
  EXPECT_EQ(robot.detector.latest().value("image transport"), kPointer);
  EXPECT_EQ(robot.depth.latest().value("depth transport"), kPointer);
}

TEST(ZeroCopy, SourceInAnotherProcessComesThroughTheNetwork) {
  const Robot robot("far");
  ASSERT_TRUE(robot.wait_for_frames(5)) << robot.objects.count() << " results";
  EXPECT_EQ(robot.detector.latest().value("image transport"), "network");
  EXPECT_EQ(robot.depth.latest().value("depth transport"), "network");
  EXPECT_EQ(robot.depth.latest().value("detections transport"), kPointer)
      << "detector and box_depth share a manager";
  EXPECT_GT(robot.objects.count(), 0U);
}

}  // namespace
}  // namespace extperfc::ros_test

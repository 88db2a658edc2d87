// When the detector listens and works, and what it says about it.
#include <algorithm>

#include <ros/param.h>
#include <vision_msgs/VisionInfo.h>

#include "extperfc/detect/inference.hpp"

#include "test/ros/detector_test.hpp"
#include "test/ros/support/simulated_time.hpp"

namespace extperfc::ros_test {
namespace {

TEST_F(DetectorTest, SubscribesOnlyWhileSomebodyListens) {
  load();
  EXPECT_TRUE(never([this] { return detector_listens(); }));
  {
    const Inbox<vision_msgs::Detection2DArray> listener("detections");
    EXPECT_TRUE(wait_for([this] { return detector_listens(); }));
  }
  EXPECT_TRUE(wait_for([this] { return !detector_listens(); })) << "no subscribers any more";
  const Inbox<sensor_msgs::Image> viewer("detections/image");
  EXPECT_TRUE(wait_for([this] { return detector_listens(); })) << "the annotated image needs images too";
}

TEST_F(DetectorTest, SilenceIsNoFaultWhileNobodyListens) {
  load({{"timeout_s", 0.1}});
  ASSERT_TRUE(diagnostics_.wait([](const Report& r) { return r.level() == 0; }));
  EXPECT_TRUE(never([this] { return diagnostics_.latest().level() != 0; }));
}

TEST_F(DetectorTest, DiagnosticsGoOnAfterTheClockRanBack) {
  load();
  ASSERT_TRUE(diagnostics_.goes_on());
  const SimulatedTime earlier(10.0);
  EXPECT_TRUE(diagnostics_.goes_on()) << "not only when the time of before is reached";
}

TEST_F(ListeningDetectorTest, AnnotatesOnlyOnDemand) {
  load_and_listen();
  ASSERT_TRUE(answer_to(to_image(draw_square(kRed), "rgb8", ros::Time(10, 0))));
  const Inbox<sensor_msgs::Image> viewer("detections/image");
  ASSERT_TRUE(wait_for([&] { return viewer.connected(); }));

  sensor_msgs::ImageConstPtr annotated;
  const auto original = to_image(draw_square(kRed), "bgr8", ros::Time(11, 0));
  const auto before = original->data;
  ASSERT_TRUE(
      wait_for([&] {  // the detector learns of its viewer a moment later than the viewer of the detector
        send(original);
        return viewer.count() > 0;
      }));
  annotated = viewer.all().front();
  EXPECT_EQ(annotated->header.stamp, ros::Time(11, 0))
      << "the image of before was drawn without a subscriber";
  EXPECT_EQ(annotated->header.frame_id, kFrame);
  EXPECT_EQ(annotated->encoding, "bgr8");
  EXPECT_NE(annotated->data, before) << "nothing was drawn";
  EXPECT_EQ(original->data, before) << "it was drawn into the camera's own image";
}

TEST_F(ListeningDetectorTest, NewestImageReplacesOneThatWaits) {
  load_and_listen({}, "square_slow");
  constexpr std::uint32_t kBurst = 12;
  for (std::uint32_t i = 1; i <= kBurst; ++i) {
    const auto received = [&](const Report& r) { return r.number("image received") >= static_cast<long>(i); };
    send(to_image(draw_square(kRed), "rgb8", ros::Time(i, 0)));
    if (i > 1) continue;
    ASSERT_TRUE(diagnostics_.wait(received));  // the detector is busy with the first when the others come
  }
  ASSERT_TRUE(detections_.wait_for_stamp(ros::Time(kBurst, 0))) << "the newest image must be the last";
  const auto answers = detections_.all();
  EXPECT_LT(answers.size(), kBurst) << "a busy detector must not queue";
  for (std::size_t i = 1; i < answers.size(); ++i)
    EXPECT_LT(answers[i - 1]->header.stamp, answers[i]->header.stamp);
  const auto unanswered = static_cast<long>(kBurst - answers.size());
  EXPECT_TRUE(diagnostics_.wait([&](const Report& r) { return r.number("dropped") == unanswered; }))
      << unanswered << " were dropped, diagnostics say " << diagnostics_.latest().value("dropped");
}

TEST_F(ListeningDetectorTest, OrderIsKeptWhenSeveralImagesAreInFlight) {
  const auto backends = detect::available_backends();
  if (std::find(backends.begin(), backends.end(), "openvino") == backends.end())
    GTEST_SKIP() << "this build has no OpenVINO, the only back end with several images in flight";
  load_and_listen({{"backend", "openvino"}, {"threads", 2}, {"mode", "throughput"}});
  constexpr std::uint32_t kImages = 200;
  for (std::uint32_t i = 1; i <= kImages; ++i) send(to_image(draw_square(kRed), "rgb8", ros::Time(i, 0)));
  ASSERT_TRUE(detections_.wait_for_stamp(ros::Time(kImages, 0)));
  const auto answers = detections_.all();
  for (std::size_t i = 1; i < answers.size(); ++i)
    ASSERT_LT(answers[i - 1]->header.stamp, answers[i]->header.stamp);
}

TEST_F(ListeningDetectorTest, PublishesWhereTheClassNamesAre) {
  load_and_listen();
  const Inbox<vision_msgs::VisionInfo> late("vision_info");
  ASSERT_TRUE(late.wait_for_count(1)) << "vision_info must be latched";
  const auto info = late.all().front();
  EXPECT_NE(info->method.find("square"), std::string::npos) << info->method;
  std::vector<std::string> names;
  ASSERT_TRUE(ros::param::get(info->database_location, names)) << info->database_location;
  EXPECT_EQ(names, (std::vector<std::string>{"red", "green", "blue", "white"}));
}

TEST_F(ListeningDetectorTest, WarnsOfASilentTopic) {
  load_and_listen({{"timeout_s", 0.3}});
  ASSERT_TRUE(answer_to(to_image(draw_square(kRed), "rgb8", ros::Time(1, 0))));
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) {
    return r.number("processed") == 1 && r.is_warning_about("no message on /camera/color/image_raw");
  }));
  ASSERT_TRUE(wait_for([this] {  // and is content as soon as images come again
    send(to_image(draw_square(kRed), "rgb8", ros::Time::now()));
    return diagnostics_.latest().level() == 0;
  }));
}

TEST_F(ListeningDetectorTest, UsesTheThresholdOfTheParameter) {
  load_and_listen({{"score_threshold", 0.99}});
  const auto none = answer_to(to_image(draw_square(kRed), "rgb8", ros::Time(1, 0)));
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->detections.empty()) << none->detections.front().results.front().score;
}

TEST_F(ListeningDetectorTest, IsUnloadedWhileImagesStream) {
  for (std::uint32_t round = 0; round < 10; ++round) {
    load_and_listen();
    const auto before = detections_.count();
    ASSERT_TRUE(wait_for([&] {
      send(to_image(draw_square(kRed), "rgb8", ros::Time::now()));
      return detections_.count() > before + round % 3;
    }));
    for (int i = 0; i < 5; ++i) send(to_image(draw_square(kRed), "rgb8", ros::Time::now()));
    manager_.unload("/detector");
    ASSERT_TRUE(wait_for([this] { return !detector_listens(); }));
  }
}

TEST_F(ListeningDetectorTest, SurvivesAStampFromTheEndOfTime) {
  load_and_listen();
  const ros::Time end(4294967295U, 999999999U);
  ASSERT_TRUE(answer_to(to_image(draw_square(kRed), "rgb8", end)));
  ASSERT_TRUE(answer_to(to_image(draw_square(kRed), "rgb8", ros::Time())));
}

}  // namespace
}  // namespace extperfc::ros_test

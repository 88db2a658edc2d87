// Parameters that change while the detector runs, and detection on request.
#include <atomic>
#include <thread>

#include <dynamic_reconfigure/ConfigDescription.h>
#include <extperfc/DetectOnce.h>
#include <ros/param.h>
#include <ros/service.h>

#include "test/ros/detector_test.hpp"
#include "test/ros/support/reconfigure_client.hpp"

namespace extperfc::ros_test {
namespace {

const ReconfigureClient kDetector("/detector");

DetectOnce::Response detect_once(const DetectOnce::Request& request) {
  DetectOnce call;
  call.request = request;
  EXPECT_TRUE(ros::service::call("/detector/detect_once", call));
  return call.response;
}

TEST_F(ListeningDetectorTest, ADisabledDetectorTakesNoImages) {
  load_and_listen();
  EXPECT_EQ(value_of(kDetector.set("enabled", false).bools, "enabled"), 0);
  EXPECT_TRUE(wait_for([this] { return !detector_listens(); })) << "it must spend no time on images";
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) {
    return r.level() == 0 && r.message() == "disabled: parameter enabled is false" &&
           r.value("enabled") == "False";
  })) << diagnostics_.latest().message();
  EXPECT_EQ(value_of(kDetector.set("enabled", true).bools, "enabled"), 1);
  ASSERT_TRUE(wait_for([this] { return detector_listens(); }));
  EXPECT_TRUE(answer_to(to_image(draw_square(kRed), "rgb8", ros::Time(1, 0))));
}

TEST_F(DetectorTest, IsDisabledFromTheStart) {
  load({{"enabled", false}});
  const Inbox<vision_msgs::Detection2DArray> listener("detections");
  ASSERT_TRUE(wait_for([&] { return listener.connected(); }));
  EXPECT_TRUE(never([this] { return detector_listens(); }));
}

TEST_F(ListeningDetectorTest, ThresholdsAndClassesChangeAtRunTime) {
  load_and_listen();
  const auto found = [this](std::uint32_t second) {
    const auto answer = answer_to(to_image(draw_square(kGreen), "rgb8", ros::Time(second, 0)));
    return answer ? answer->detections.size() : 99U;
  };
  EXPECT_EQ(found(1), 1U);
  kDetector.set("score_threshold", 0.99);
  EXPECT_EQ(found(2), 0U);
  kDetector.set("score_threshold", -1.0);
  EXPECT_EQ(found(3), 1U);
  kDetector.set("class_filter", "red, 2");
  EXPECT_EQ(found(4), 0U);
  kDetector.set("class_filter", "green");
  EXPECT_EQ(found(5), 1U);
  std::string stored;
  EXPECT_TRUE(ros::param::get("/detector/class_filter", stored));
  EXPECT_EQ(stored, "green");
}

TEST_F(DetectorTest, WrongValuesAreRefusedWithAReason) {
  load({{"score_threshold", 0.4}});
  const auto refused = [this](const dynamic_reconfigure::Config& in_force, const std::string& reason) {
    EXPECT_EQ(value_of(in_force.doubles, "score_threshold"), 0.4);
    EXPECT_EQ(value_of(in_force.strs, "class_filter"), "");
    EXPECT_TRUE(log_.wait(reason)) << log_.text();
    EXPECT_TRUE(diagnostics_.wait_latest([&](const Report& r) { return r.is_warning_about(reason); }))
        << diagnostics_.latest().message();
  };
  refused(kDetector.set("score_threshold", 1.5), "score_threshold = 1.5 is out of its range [-1, 1]");
  refused(kDetector.set("class_filter", "red, pink"), "no class \"pink\"");
  refused(kDetector.set("score_threshold", true), "is of type double, not bool");
  refused(kDetector.set("model", "other"), "cannot be changed while the node runs");
  double stored = 0;
  EXPECT_TRUE(ros::param::get("/detector/score_threshold", stored));
  EXPECT_EQ(stored, 0.4) << "what was refused must not be read at the next start";
  EXPECT_EQ(value_of(kDetector.set("score_threshold", 0.6).doubles, "score_threshold"), 0.6);
  EXPECT_TRUE(diagnostics_.wait_latest([](const Report& r) { return r.level() == 0; }));
}

TEST_F(DetectorTest, DescribesItsParametersForTools) {
  load();
  Inbox<dynamic_reconfigure::Config> updates("/detector/parameter_updates");
  ASSERT_TRUE(updates.wait_for_count(1)) << "latched";
  EXPECT_EQ(value_of(updates.all().front()->doubles, "score_threshold"), -1.0);
  Inbox<dynamic_reconfigure::ConfigDescription> descriptions("/detector/parameter_descriptions");
  ASSERT_TRUE(descriptions.wait_for_count(1));
  const auto description = descriptions.all().front();
  ASSERT_EQ(description->groups.size(), 1U);
  EXPECT_EQ(description->groups.front().parameters.size(), 5U);
  EXPECT_EQ(value_of(description->min.doubles, "score_threshold"), -1.0);
  EXPECT_EQ(value_of(description->max.doubles, "score_threshold"), 1.0);
  EXPECT_EQ(value_of(description->max.ints, "max_detections"), 10000);
}

TEST_F(DetectorTest, DetectsInAGivenImage) {
  load({{"enabled", false}});
  DetectOnce::Request request;
  request.image = *to_image(draw_square(kBlue), "rgb8", ros::Time(7, 0));
  const auto response = detect_once(request);
  ASSERT_TRUE(response.success) << response.message;
  EXPECT_EQ(response.detections.header.stamp, ros::Time(7, 0));
  EXPECT_EQ(response.detections.header.frame_id, kFrame);
  ASSERT_EQ(response.detections.detections.size(), 1U);
  EXPECT_EQ(response.detections.detections.front().results.front().id, kClassBlue);
  EXPECT_FALSE(response.has_3d);
  EXPECT_FALSE(detector_listens());

  request.image.encoding = "jpeg2000";
  const auto refused = detect_once(request);
  EXPECT_FALSE(refused.success);
  EXPECT_NE(refused.message.find("'jpeg2000' is not supported"), std::string::npos) << refused.message;
}

TEST_F(DetectorTest, DetectsInTheNextImageAndUnsubscribes) {
  load({{"enabled", false}});
  DetectOnce::Response response;
  std::thread caller([&] { response = detect_once({}); });
  EXPECT_TRUE(wait_for([this] { return detector_listens(); }));
  send(to_image(draw_square(kRed), "rgb8", ros::Time(3, 0)));
  caller.join();
  ASSERT_TRUE(response.success) << response.message;
  EXPECT_EQ(response.detections.header.stamp, ros::Time(3, 0));
  ASSERT_EQ(response.detections.detections.size(), 1U);
  EXPECT_EQ(response.detections.detections.front().results.front().id, kClassRed);
  EXPECT_TRUE(wait_for([this] { return !detector_listens(); }));
}

TEST_F(ListeningDetectorTest, ARequestIsServedWhileImagesStream) {
  load_and_listen({}, "square_slow");
  DetectOnce::Response response;
  std::atomic<bool> done{false};
  std::thread caller([&] {
    response = detect_once({});
    done = true;
  });
  std::uint32_t second = 0;
  EXPECT_TRUE(wait_for([&] {
    send(to_image(draw_square(kRed), "rgb8", ros::Time(++second, 0)));
    return done.load();
  }));
  caller.join();
  EXPECT_TRUE(response.success) << response.message;
  EXPECT_TRUE(detections_.wait_for_stamp(response.detections.header.stamp)) << "it is one of the stream, too";
}

TEST_F(DetectorTest, ARequestWithoutACameraEnds) {
  load();
  DetectOnce::Request request;
  request.timeout = ros::Duration(0.2);
  const auto response = detect_once(request);
  EXPECT_FALSE(response.success);
  EXPECT_EQ(response.message,
            "no image came within 0.200000 s: is the camera running, and does its topic have this name?");
}

TEST_F(DetectorTest, IsUnloadedWhileARequestWaits) {
  load();
  bool answered = true;
  std::thread caller([&] {
    DetectOnce call;
    call.request.timeout = ros::Duration(3600.0);
    answered = ros::service::call("/detector/detect_once", call) && call.response.success;
  });
  EXPECT_TRUE(wait_for([this] { return detector_listens(); }));
  manager_.unload("/detector");
  caller.join();
  EXPECT_FALSE(answered);
}

}  // namespace
}  // namespace extperfc::ros_test

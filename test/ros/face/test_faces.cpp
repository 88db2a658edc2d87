// Faces and their positions, what is drawn, and what is refused.
#include <geometry_msgs/TransformStamped.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <visualization_msgs/MarkerArray.h>

#include "test/ros/face/faces_test.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

class LonelyFacesTest : public testing::Test {
 protected:
  ros::Publisher images_{ros::NodeHandle().advertise<sensor_msgs::Image>("camera/color/image_raw", 10)};
  LogWatch log_;
  Manager manager_;
};

TEST_F(LonelyFacesTest, SubscribesOnlyForSubscribers) {
  const Params params{{"model", model_folder("red_nose")}, {"backend", "opencv"}};
  ASSERT_TRUE(manager_.load("/faces", "faces", params)) << log_.text();
  EXPECT_TRUE(never([this] { return images_.getNumSubscribers() > 0; }));
  {
    const Inbox<FaceArray> listener("faces");
    EXPECT_TRUE(wait_for([this] { return images_.getNumSubscribers() > 0; }));
  }
  EXPECT_TRUE(wait_for([this] { return images_.getNumSubscribers() == 0; }));
  const Inbox<visualization_msgs::MarkerArray> viewer("faces/markers");
  EXPECT_TRUE(wait_for([this] { return images_.getNumSubscribers() > 0; }));
}

TEST_F(FacesTest, WithoutDepthFacesHaveNoPosition) {
  load();
  const auto answer = answer_to(image_of(1, ros::Time(1, 0)));
  ASSERT_TRUE(answer) << diagnostics_.latest().message();
  EXPECT_EQ(answer->header.frame_id, kFrame);
  ASSERT_EQ(answer->faces.size(), 1U);
  const auto& face = answer->faces.front();
  EXPECT_NEAR(face.bbox.center.x, 176, 0.5);
  EXPECT_NEAR(face.bbox.center.y, 144, 0.5);
  EXPECT_NEAR(face.bbox.size_x, 96, 0.5);
  EXPECT_NEAR(face.landmarks[2].x, 176, 1) << "the nose";
  EXPECT_GT(face.landmarks[2].y, face.landmarks[0].y);
  EXPECT_GT(face.score, 0.9F);
  EXPECT_EQ(face.name, "");
  EXPECT_EQ(face.similarity, 0.0F) << "no name is enrolled";
  EXPECT_FALSE(face.has_position);
  EXPECT_TRUE(diagnostics_.wait(
      [](const Report& r) { return r.is_warning_about("no positions: no depth image has the stamp"); }));
}

TEST_F(FacesTest, WithoutDepthWantedThereIsNothingToWarnOf) {
  load({{"use_depth", false}});
  EXPECT_EQ(depth_.getNumSubscribers(), 0U);
  ASSERT_TRUE(answer_to(image_of(1, ros::Time(1, 0))));
  ASSERT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("faces") == 1; }));
  EXPECT_EQ(diagnostics_.latest().level(), 0) << diagnostics_.latest().message();
}

TEST_F(FacesTest, ARateCanBeTheLimit) {
  load({{"use_depth", false}, {"max_rate_hz", 2.0}});
  const Inbox<FaceArray> all("faces");
  ASSERT_TRUE(wait_for([&] { return all.connected(); }));
  ASSERT_TRUE(answer_to(image_of(1, ros::Time(1, 0))));
  images_.publish(image_of(1, ros::Time(1, 300000000)));
  ASSERT_TRUE(answer_to(image_of(1, ros::Time(1, 600000000))));
  EXPECT_EQ(all.count(), 2U);
}

TEST_F(FacesTest, AnImageWithoutFacesHasAnEmptyAnswer) {
  load();
  const auto answer = answer_to(image_of(0, ros::Time(1, 0)));
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->faces.empty());
}

class LocatedFacesTest : public FacesTest {
 protected:
  /// Depth comes before the image, and camera info before both.
  FaceArrayConstPtr locate(const ros::Time& stamp, double face_m) {
    const auto info = camera_info(stamp, kFacesSize);
    EXPECT_TRUE(wait_for([&] {
      info_.publish(info);
      return diagnostics_.latest().number("camera info received") > 0;
    }));
    depth_.publish(depth_image(3.0, face_m, face_box({5, 4}), "16UC1", stamp, kFacesSize));
    return answer_to(image_of(1, stamp));
  }
};

TEST_F(LocatedFacesTest, PositionIsThePointBehindTheMiddleOfTheBox) {
  load();
  const auto answer = locate(ros::Time(5, 0), 1.5);
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->faces.size(), 1U);
  const auto& face = answer->faces.front();
  ASSERT_TRUE(face.has_position) << diagnostics_.latest().message();
  EXPECT_NEAR(face.position.x, (175.5 - 159.5) * 1.5 / kFocalPx, 0.005);
  EXPECT_NEAR(face.position.y, (143.5 - 159.5) * 1.5 / kFocalPx, 0.005);
  EXPECT_NEAR(face.position.z, 1.5, 0.005);
}

TEST_F(LocatedFacesTest, PositionsAreInTheTargetFrame) {
  tf2_ros::StaticTransformBroadcaster broadcaster;
  geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "room";
  transform.child_frame_id = kFrame;
  transform.transform.translation.x = 10.0;
  transform.transform.rotation.w = 1.0;
  broadcaster.sendTransform(transform);
  load({{"target_frame", "room"}, {"transform_timeout_s", 5.0}});
  const auto answer = locate(ros::Time(5, 0), 1.5);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->header.frame_id, "room");
  ASSERT_TRUE(answer->faces.at(0).has_position) << diagnostics_.latest().message();
  EXPECT_NEAR(answer->faces[0].position.x, 10.08, 0.005);
}

TEST_F(LocatedFacesTest, AMissingTransformCostsThePositionsOnly) {
  load({{"target_frame", "moon"}, {"transform_timeout_s", 0.0}});
  const auto answer = locate(ros::Time(5, 0), 1.5);
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->faces.size(), 1U);
  EXPECT_FALSE(answer->faces[0].has_position);
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.is_warning_about("no transform from"); }));
}

TEST_F(LocatedFacesTest, MarkersStandAtThePositions) {
  load();
  const Inbox<visualization_msgs::MarkerArray> markers("faces/markers");
  ASSERT_TRUE(wait_for([&] { return markers.connected(); }));
  std::uint32_t second = 5;
  ASSERT_TRUE(wait_for([&] {
    EXPECT_TRUE(locate(ros::Time(++second, 0), 1.5));
    return markers.count() > 0;
  }));
  const auto all = markers.all().front()->markers;
  ASSERT_EQ(all.size(), 3U) << "clear, ball and name";
  EXPECT_NEAR(all[1].pose.position.z, 1.5, 0.005);
  EXPECT_EQ(all[2].text, "unknown");
}

TEST_F(FacesTest, DrawsOnlyForSubscribers) {
  load();
  ASSERT_TRUE(answer_to(image_of(1, ros::Time(1, 0))));
  const Inbox<sensor_msgs::Image> viewer("faces/image");
  ASSERT_TRUE(wait_for([&] { return viewer.connected(); }));
  const auto original = image_of(1, ros::Time(2, 0));
  const auto before = original->data;
  ASSERT_TRUE(wait_for([&] {
    images_.publish(original);
    return viewer.count() > 0;
  }));
  EXPECT_EQ(viewer.all().front()->encoding, "bgr8");
  EXPECT_EQ(viewer.all().front()->header.stamp, ros::Time(2, 0))
      << "the first was drawn without a subscriber";
  EXPECT_EQ(original->data, before) << "it was drawn into the camera's own image";
}

TEST_F(FacesTest, AnUnreadableImageIsAnErrorAndTheNextOneWorks) {
  load();
  const auto unreadable = image_of(1, ros::Time(1, 0));
  unreadable->encoding = "32FC3";
  images_.publish(unreadable);
  EXPECT_TRUE(log_.wait("refused an image"));
  EXPECT_TRUE(answer_to(image_of(1, ros::Time(2, 0))));
}

TEST_F(FacesTest, IsUnloadedWhileImagesStream) {
  for (std::uint32_t round = 0; round < 5; ++round) {
    load();
    for (std::uint32_t i = 0; i < 5; ++i) images_.publish(image_of(1, ros::Time(10 + round, i)));
    manager_.unload("/faces");
    ASSERT_TRUE(wait_for([this] { return images_.getNumSubscribers() == 0; }));
  }
}

class RefusalTest : public FacesTest {
 protected:
  void expect_refusal(const Params& params, const std::vector<std::string>& texts) {
    log_.forget();
    EXPECT_FALSE(manager_.load("/victim", "faces", params));
    ASSERT_TRUE(log_.wait(texts.front())) << texts.front() << " is not in\n" << log_.text();
    for (const auto& text : texts)
      EXPECT_NE(log_.text().find(text), std::string::npos) << text << "\n" << log_.text();
    EXPECT_EQ(log_.count(texts.front()), 1U) << "once is enough:\n" << log_.text();
  }
};

TEST_F(RefusalTest, WhatIsNoFaceDetector) {
  expect_refusal({}, {"/victim/model is not set: name the folder of a YuNet"});
  expect_refusal(faces_params({{"model", "/no/such/model"}}), {"there is no model folder /no/such/model"});
  expect_refusal(faces_params({{"model", model_folder("square")}}), {"faces need one of layout yunet"});
}

TEST_F(RefusalTest, WhatIsNoEmbedder) {
  expect_refusal(faces_params({{"embedder", "/no/such.onnx"}}),
                 {"neither an ONNX file nor a model folder: /no/such.onnx"});
  expect_refusal(faces_params({{"embedder", model_folder("square")}}), {"needs the layout vector"});
}

TEST_F(RefusalTest, AGalleryOfAnotherEmbedder) {
  const TemporaryFolder folder;
  const auto file = folder.write("names.yaml", "format: 1\nembedder: other\nsize: 3\npeople: []\n");
  expect_refusal(faces_params({{"gallery", file.string()}}), {"enroll again", file.string()});
}

TEST_F(RefusalTest, EveryWrongParameterIsNamedAtOnce) {
  expect_refusal(
      faces_params({{"max_faces", -1}, {"margn", 0.1}, {"min_depth_m", 5.0}, {"max_depth_m", 1.0}}),
      {"/victim/max_faces = -1 is out of its range [0, 1000]",
       "/victim/margn is not a parameter of this nodelet", "max_depth_m"});
}

}  // namespace
}  // namespace extperfc::ros_test

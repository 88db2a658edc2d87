// Names: enrolling, recognizing, forgetting.
#include <atomic>
#include <filesystem>
#include <functional>
#include <thread>

#include "test/ros/face/faces_test.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::ros_test {
namespace {

constexpr int kAda = 1;
constexpr int kGrace = 2;

class EnrollTest : public FacesTest {
 protected:
  /// Calls the service while a camera runs at 10 images per second of its own time.
  EnrollFace::Response enroll(const std::string& name, int samples, double timeout_s,
                              const std::function<sensor_msgs::ImagePtr(const ros::Time&)>& image) {
    std::atomic<bool> done{false};
    std::thread camera([&] {
      while (!done) {
        if (image) images_.publish(image(stamp_ += ros::Duration(0.1)));
        (void)wait_for([&] { return done.load(); }, 0.02);
      }
    });
    EnrollFace call;
    call.request.name = name;
    call.request.samples = samples;
    call.request.timeout = ros::Duration(timeout_s);
    EXPECT_TRUE(ros::service::call("/faces/enroll", call));
    done = true;
    camera.join();
    return call.response;
  }

  EnrollFace::Response enroll(const std::string& name, int person, int samples = 3) {
    return enroll(name, samples, 20.0, [person](const ros::Time& stamp) { return image_of(person, stamp); });
  }

  ForgetFace::Response forget(const std::string& name) {
    ForgetFace call;
    call.request.name = name;
    EXPECT_TRUE(ros::service::call("/faces/forget", call));
    return call.response;
  }

  ros::Time later() { return stamp_ += ros::Duration(10.0); }

  ros::Time stamp_{100, 0};
  TemporaryFolder folder_;
};

TEST_F(EnrollTest, WhoWasEnrolledHasANameAndOthersHaveNot) {
  load();
  EXPECT_EQ(name_of(kAda, later()), "");
  const auto enrolled = enroll("Ada", kAda);
  ASSERT_TRUE(enrolled.success) << enrolled.message;
  EXPECT_EQ(enrolled.samples, 3);
  EXPECT_EQ(enrolled.total, 3);
  EXPECT_EQ(enrolled.message, "");
  EXPECT_EQ(name_of(kAda, later()), "Ada");
  EXPECT_EQ(name_of(kGrace, later()), "") << "a stranger";
  ASSERT_TRUE(enroll("Grace", kGrace).success);
  EXPECT_EQ(name_of(kGrace, later()), "Grace");
  EXPECT_EQ(name_of(kAda, later()), "Ada");
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.number("names") == 2; }));
}

TEST_F(EnrollTest, TheThresholdDecides) {
  load({{"threshold", 1.0}, {"enroll_interval_s", 0.0}});
  ASSERT_TRUE(enroll("Ada", kAda, 1).success);
  const auto darker = image_of(kAda, later());
  for (auto& value : darker->data) value = static_cast<std::uint8_t>(value * 9 / 10);
  const auto answer = answer_to(darker);
  ASSERT_TRUE(answer && answer->faces.size() == 1);
  EXPECT_EQ(answer->faces[0].name, "");
  EXPECT_GT(answer->faces[0].similarity, 0.85F);
}

TEST_F(EnrollTest, NamesOutliveTheNodeletInTheirFile) {
  const Params params{{"gallery", (folder_.path() / "new/names.yaml").string()}};
  load(params);
  ASSERT_TRUE(enroll("Ada", kAda).success);
  manager_.unload("/faces");
  ASSERT_TRUE(wait_for([this] { return images_.getNumSubscribers() == 0; }));
  load(params);
  EXPECT_EQ(name_of(kAda, later()), "Ada");
  EXPECT_TRUE(forget("Ada").success);
  manager_.unload("/faces");
  ASSERT_TRUE(wait_for([this] { return images_.getNumSubscribers() == 0; }));
  load(params);
  EXPECT_EQ(name_of(kAda, later()), "");
}

TEST_F(EnrollTest, AChangeThatCannotBeWrittenDoesNotHappen) {
  const auto file = folder_.write("file", "");
  load({{"gallery", (file / "names.yaml").string()}});
  const auto enrolled = enroll("Ada", kAda, 1);
  EXPECT_FALSE(enrolled.success);
  EXPECT_NE(enrolled.message.find("file"), std::string::npos) << enrolled.message;
  EXPECT_EQ(name_of(kAda, later()), "");
}

TEST_F(EnrollTest, ForgettingAnUnknownNameSaysWhoIsKnown) {
  load();
  ASSERT_TRUE(enroll("Ada", kAda, 1).success);
  const auto wrong = forget("Grace");
  EXPECT_FALSE(wrong.success);
  EXPECT_NE(wrong.message.find("Ada"), std::string::npos) << wrong.message;
  EXPECT_TRUE(forget("Ada").success);
  EXPECT_EQ(name_of(kAda, later()), "");
}

TEST_F(EnrollTest, ReasonsWhyNoFaceWasEnrolled) {
  load();
  const auto silent = enroll("Ada", 1, 0.3, nullptr);
  EXPECT_FALSE(silent.success);
  EXPECT_NE(silent.message.find("no image came within 0.3 s"), std::string::npos) << silent.message;
  const auto empty = enroll("Ada", 1, 0.5, [](const ros::Time& stamp) { return image_of(0, stamp); });
  EXPECT_FALSE(empty.success);
  EXPECT_NE(empty.message.find("no face that is large enough"), std::string::npos) << empty.message;
  const auto nameless = enroll("", kAda);
  EXPECT_FALSE(nameless.success);
  EXPECT_NE(nameless.message.find("cannot be used"), std::string::npos) << nameless.message;
}

TEST_F(EnrollTest, AnotherPersonIsNoSample) {
  load({{"enroll_interval_s", 0.0}});
  int count = 0;
  const auto enrolled = enroll(
      "Ada", 1000, 3.0, [&](const ros::Time& stamp) { return image_of(++count > 5 ? kGrace : kAda, stamp); });
  ASSERT_TRUE(enrolled.success) << enrolled.message;
  EXPECT_NE(enrolled.message.find("with a face unlike the first one"), std::string::npos) << enrolled.message;
  EXPECT_LE(enrolled.samples, 5);
  EXPECT_EQ(name_of(kGrace, later()), "");
}

TEST_F(EnrollTest, OneFaceUnderTwoNamesIsReportedAndUnknown) {
  load();
  ASSERT_TRUE(enroll("Ada", kAda, 1).success);
  const auto again = enroll("Adele", kAda, 1);
  ASSERT_TRUE(again.success) << again.message;
  EXPECT_NE(again.message.find("resembles Ada, too"), std::string::npos) << again.message;
  EXPECT_EQ(name_of(kAda, later()), "");
}

TEST_F(EnrollTest, OfTwoFacesTheNearestIsEnrolled) {
  load({{"enroll_interval_s", 0.0}});
  const Cell left{2, 4};
  const Cell right{7, 4};
  const auto info = camera_info(ros::Time(1, 0), kFacesSize);
  ASSERT_TRUE(wait_for([&] {
    info_.publish(info);
    return diagnostics_.latest().number("camera info received") > 0;
  }));
  const auto both = [&](const ros::Time& stamp) {
    depth_.publish(depth_image(3.0, 1.0, face_box(right), "16UC1", stamp, kFacesSize));
    cv::Mat3b rgb(kFacesSize, cv::Vec3b(60, 60, 60));
    draw_person(rgb, kAda, left);
    draw_person(rgb, kGrace, right);
    return to_image(rgb, "rgb8", stamp);
  };
  const auto enrolled = enroll("Grace", 2, 20.0, both);
  ASSERT_TRUE(enrolled.success) << enrolled.message;
  EXPECT_EQ(name_of(kGrace, later()), "Grace");
  EXPECT_EQ(name_of(kAda, later()), "");
}

TEST(LonelyEnrollTest, TakesImagesForARequestAndEndsItWithTheNodelet) {
  const auto images = ros::NodeHandle().advertise<sensor_msgs::Image>("camera/color/image_raw", 10);
  Manager manager;
  ASSERT_TRUE(manager.load("/faces", "faces", {{"model", model_folder("red_nose")}, {"backend", "opencv"}}));
  std::thread caller([] {
    EnrollFace call;
    call.request.name = "Ada";
    call.request.timeout = ros::Duration(600.0);
    EXPECT_FALSE(ros::service::call("/faces/enroll", call));
  });
  EXPECT_TRUE(wait_for([&] { return images.getNumSubscribers() > 0; })) << "a request needs images";
  manager.unload("/faces");
  caller.join();
}

}  // namespace
}  // namespace extperfc::ros_test

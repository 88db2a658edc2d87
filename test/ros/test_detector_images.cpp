// What the detector finds in images of all kinds, and what it says about those that it cannot read.
#include "test/ros/detector_test.hpp"

namespace extperfc::ros_test {
namespace {

struct Encoding {
  const char* name;
  int expected_class;
};

void PrintTo(const Encoding& encoding, std::ostream* out) {
  *out << encoding.name;
}

class EncodingTest : public ListeningDetectorTest, public testing::WithParamInterface<Encoding> {};

TEST_P(EncodingTest, TheSquareIsFoundWithItsColour) {
  load_and_listen();
  const bool grey = GetParam().expected_class == kClassWhite;
  const auto answer =
      answer_to(to_image(draw_square(grey ? kWhite : kRed), GetParam().name, ros::Time(5, 6)));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->header.stamp, ros::Time(5, 6));
  EXPECT_EQ(answer->header.frame_id, kFrame);
  ASSERT_EQ(answer->detections.size(), 1U);
  const auto& detection = answer->detections.front();
  EXPECT_EQ(detection.header.stamp, ros::Time(5, 6));
  ASSERT_EQ(detection.results.size(), 1U);
  EXPECT_EQ(detection.results.front().id, GetParam().expected_class);
  EXPECT_GT(detection.results.front().score, 0.5);
  constexpr double kTolerancePx = 1.5;  // of Bayer and chroma interpolation at the square's edges
  EXPECT_NEAR(detection.bbox.center.x, 120, kTolerancePx);
  EXPECT_NEAR(detection.bbox.center.y, 90, kTolerancePx);
  EXPECT_NEAR(detection.bbox.size_x, 80, 2 * kTolerancePx);
  EXPECT_NEAR(detection.bbox.size_y, 60, 2 * kTolerancePx);
}

TEST_P(EncodingTest, AnAnnotatedImageComesOut) {
  load_and_listen();
  const Inbox<sensor_msgs::Image> viewer("detections/image");
  ASSERT_TRUE(wait_for([&] { return viewer.connected(); }));
  EXPECT_TRUE(wait_for([&] {
    send(to_image(draw_square(kRed), GetParam().name, ros::Time::now()));
    return viewer.count() > 0;
  })) << log_.text();
}

INSTANTIATE_TEST_SUITE_P(All, EncodingTest,
                         testing::Values(Encoding{"rgb8", kClassRed}, Encoding{"bgr8", kClassRed},
                                         Encoding{"rgba8", kClassRed}, Encoding{"bgra8", kClassRed},
                                         Encoding{"mono8", kClassWhite}, Encoding{"mono16", kClassWhite},
                                         Encoding{"bayer_rggb8", kClassRed},
                                         Encoding{"bayer_bggr8", kClassRed},
                                         Encoding{"bayer_gbrg8", kClassRed},
                                         Encoding{"bayer_grbg8", kClassRed}, Encoding{"yuv422", kClassRed},
                                         Encoding{"yuv422_yuy2", kClassRed}),
                         [](const auto& test) { return std::string(test.param.name); });

/// An image that cannot be read, and what must be said about it.
struct Fault {
  const char* name;
  void (*spoil)(sensor_msgs::Image&);
  const char* complaint;
};

void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.name;
}

class FaultTest : public ListeningDetectorTest, public testing::WithParamInterface<Fault> {};

TEST_P(FaultTest, IsNamedOnceAndTheNextGoodImageIsFound) {
  load_and_listen();
  constexpr int kBadImages = 4;
  for (int i = 1; i <= kBadImages; ++i) {
    auto bad = to_image(draw_square(kRed), "rgb8", ros::Time(i, 0));
    GetParam().spoil(*bad);
    send(bad);
    ASSERT_TRUE(diagnostics_.wait([i](const Report& r) { return r.number("failed") == i; }));
  }
  EXPECT_TRUE(diagnostics_.wait([](const Report& r) { return r.is_error_about(GetParam().complaint); }))
      << diagnostics_.latest().message();
  EXPECT_TRUE(log_.wait(GetParam().complaint)) << log_.text();

  const auto answer = answer_to(to_image(draw_square(kRed), "rgb8", ros::Time(100, 0)));
  ASSERT_TRUE(answer) << "the detector must go on";
  EXPECT_EQ(answer->detections.size(), 1U);
  EXPECT_TRUE(
      diagnostics_.wait([](const Report& r) { return r.number("processed") == 1 && r.level() == 0; }));
  EXPECT_EQ(detections_.count(), 1U) << "nothing is published for an image that cannot be read";
  EXPECT_EQ(log_.count(GetParam().complaint), 1U) << log_.text();
}

INSTANTIATE_TEST_SUITE_P(
    All, FaultTest,
    testing::Values(
        Fault{"unknown_encoding", [](sensor_msgs::Image& image) { image.encoding = "jpeg"; }, "'jpeg'"},
        Fault{"no_encoding", [](sensor_msgs::Image& image) { image.encoding.clear(); }, "encoding ''"},
        Fault{"depth",
              [](sensor_msgs::Image& image) {
                image.encoding = "32FC1";
                image.step = 4 * image.width;
                image.data.resize(static_cast<std::size_t>(image.step) * image.height);
              },
              "32FC1"},
        Fault{"empty", [](sensor_msgs::Image& image) { image.width = image.height = 0; }, "empty"},
        Fault{"no_data", [](sensor_msgs::Image& image) { image.data.clear(); }, "empty"},
        Fault{"too_short", [](sensor_msgs::Image& image) { image.data.resize(image.data.size() / 2); },
              "needs 230400 bytes, but the message has 115200"},
        Fault{"narrow_step", [](sensor_msgs::Image& image) { image.step = image.width; },
              "the message's step is 320"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST_F(ListeningDetectorTest, RowsMayBePadded) {
  load_and_listen();
  const auto tight = to_image(draw_square(kRed), "rgb8", ros::Time(1, 0));
  auto padded = boost::make_shared<sensor_msgs::Image>(*tight);
  constexpr std::uint32_t kPadding = 64;
  padded->step += kPadding;
  padded->data.assign(static_cast<std::size_t>(padded->step) * padded->height, 255);
  for (std::size_t y = 0; y < tight->height; ++y)
    std::copy_n(tight->data.begin() + static_cast<std::ptrdiff_t>(y * tight->step), tight->step,
                padded->data.begin() + static_cast<std::ptrdiff_t>(y * padded->step));
  const auto answer = answer_to(padded);
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->detections.size(), 1U);
  EXPECT_NEAR(answer->detections.front().bbox.center.x, 120, 0.5);
}

TEST_F(ListeningDetectorTest, SizeMayChangeBetweenImages) {
  load_and_listen();
  ASSERT_TRUE(answer_to(to_image(draw_square(kRed), "rgb8", ros::Time(1, 0))));
  const cv::Mat3b half = draw_square(kRed)(cv::Rect(0, 0, 160, 120)).clone();
  const auto answer = answer_to(to_image(half, "rgb8", ros::Time(2, 0)));
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->detections.size(), 1U);
  EXPECT_NEAR(answer->detections.front().bbox.center.x, 120, 1.5);
}

}  // namespace
}  // namespace extperfc::ros_test

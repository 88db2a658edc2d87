#include <boost/make_shared.hpp>
#include <gtest/gtest.h>

#include "ros/convert/annotate.hpp"

namespace extperfc::ros_convert {
namespace {

sensor_msgs::ImagePtr grey_image(const std::string& encoding, std::uint32_t channels) {
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->header.frame_id = "optical";
  message->header.stamp = ros::Time(3, 4);
  message->encoding = encoding;
  message->width = 64;
  message->height = 48;
  message->step = 64 * channels;
  message->data.assign(static_cast<std::size_t>(message->step) * 48, 128);
  return message;
}

TEST(Annotate, DrawsIntoACopy) {
  for (const auto& [encoding, channels] : std::vector<std::pair<std::string, std::uint32_t>>{
           {"bgr8", 3}, {"rgb8", 3}, {"mono8", 1}, {"bgra8", 4}}) {
    const auto original = grey_image(encoding, channels);
    const auto before = original->data;
    const auto shared = share_image(original);
    ASSERT_TRUE(shared);
    const auto drawn = annotate(*shared, {{0, 0.9F, {10, 20, 40, 40}}}, {"cup"});
    ASSERT_TRUE(drawn) << drawn.error().message;
    EXPECT_EQ(original->data, before) << encoding << ": the camera's image must stay as it is";
    EXPECT_EQ((*drawn)->encoding, "bgr8");
    EXPECT_EQ((*drawn)->header.stamp, ros::Time(3, 4));
    EXPECT_EQ((*drawn)->header.frame_id, "optical");
    EXPECT_NE((*drawn)->data, std::vector<std::uint8_t>(64 * 48 * 3, 128))
        << encoding << ": nothing was drawn";
  }
}

TEST(Annotate, WithoutDetectionsItIsTheImage) {
  const auto shared = share_image(grey_image("bgr8", 3));
  const auto drawn = annotate(*shared, {}, {});
  ASSERT_TRUE(drawn);
  EXPECT_EQ((*drawn)->data, std::vector<std::uint8_t>(64 * 48 * 3, 128));
}

TEST(Annotate, BoxesBeyondTheImageAndUnknownClassesDoNoHarm) {
  const auto shared = share_image(grey_image("bgr8", 3));
  EXPECT_TRUE(annotate(*shared, {{-1, 0.9F, {-500, -500, 5000, 5000}}, {99, 0.1F, {60, 0, 64, 2}}}, {"cup"}));
}

}  // namespace
}  // namespace extperfc::ros_convert

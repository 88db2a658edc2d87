#include "test/benchmark/transport/pair_sender.hpp"

#include <cstdint>

#include <sensor_msgs/image_encodings.h>

namespace extperfc::benchmark {

namespace {

constexpr std::uint32_t kWidth = 640;
constexpr std::uint32_t kHeight = 480;
constexpr std::uint32_t kQueue = 10;

sensor_msgs::ImagePtr make_image(const std::string& encoding, std::uint32_t pixel_bytes) {
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.frame_id = "camera_color_optical_frame";
  image->width = kWidth;
  image->height = kHeight;
  image->encoding = encoding;
  image->step = kWidth * pixel_bytes;
  image->data.resize(static_cast<std::size_t>(image->step) * kHeight);
  for (std::size_t i = 0; i < image->data.size(); ++i)
    image->data[i] = static_cast<std::uint8_t>(i * 31 + i / 997);
  return image;
}

void stamp(const ImagePair& pair) {
  pair.color->header.stamp = pair.depth->header.stamp = ros::Time::now();
}

}  // namespace

ImagePair make_pair() {
  return {make_image(sensor_msgs::image_encodings::RGB8, 3),
          make_image(sensor_msgs::image_encodings::TYPE_16UC1, 2)};
}

PairSender::PairSender(const std::string& ns)
    : handle_(ns),
      color_(handle_.advertise<sensor_msgs::Image>("color", kQueue)),
      depth_(handle_.advertise<sensor_msgs::Image>("depth", kQueue)) {}

bool PairSender::connected() const {
  return color_.getNumSubscribers() > 0 && depth_.getNumSubscribers() > 0;
}

void PairSender::send_pointers(const ImagePair& pair) {
  stamp(pair);
  depth_.publish(pair.depth);
  color_.publish(pair.color);
}

void PairSender::send_references(const ImagePair& pair) {
  stamp(pair);
  depth_.publish(*pair.depth);
  color_.publish(*pair.color);
}

}  // namespace extperfc::benchmark

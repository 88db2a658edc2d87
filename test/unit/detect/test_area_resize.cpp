#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "extperfc/detect/preprocess.hpp"

#include "detect/area_resize.hpp"

namespace extperfc::detect {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr std::array<int, 3> kChannelCounts{1, 3, 4};

struct Sizes {
  cv::Size from;
  cv::Size to;
};

const std::vector<Sizes> kSizes{
    {{640, 480}, {352, 352}}, {{640, 480}, {320, 160}}, {{64, 48}, {63, 47}}, {{64, 48}, {64, 31}},
    {{64, 48}, {29, 48}},     {{97, 61}, {13, 7}},      {{60, 60}, {20, 15}}, {{500, 300}, {3, 2}},
    {{5, 4}, {1, 1}},         {{2, 3}, {1, 2}},         {{9, 1}, {5, 1}},
};

std::string name_of(const Sizes& sizes, int channels) {
  return cv::format("%d x %d to %d x %d, %d channels, seed %d", sizes.from.width, sizes.from.height,
                    sizes.to.width, sizes.to.height, channels, static_cast<int>(kSeed));
}

/// A part of a wider image, so that rows are padded.
cv::Mat random_image(cv::Size size, int channels) {
  cv::RNG rng(kSeed);
  cv::Mat wide(size.height, size.width + 5, CV_8UC(channels));
  rng.fill(wide, cv::RNG::UNIFORM, 0, 256);
  return wide(cv::Rect({2, 0}, size));
}

/// Planes of the last three channels in reverse order, each with its own scale and offset.
std::array<AreaPlane, 3> planes_of(cv::Size size, int channels) {
  std::array<AreaPlane, 3> planes;
  for (int c = 0; c < 3; ++c)
    planes[static_cast<std::size_t>(c)] = {cv::Mat(size, CV_32F, cv::Scalar(-1e9)),
                                           std::max(0, channels - 1 - c), 0.5 * (c + 1), 10.0 * c};
  return planes;
}

TEST(AreaResizer, GivesWhatOpenCvGives) {
  AreaResizer resizer;  // one for all: it follows changes of size and channels
  for (const Sizes& sizes : kSizes)
    for (const int channels : kChannelCounts) {
      const cv::Mat image = random_image(sizes.from, channels);
      ASSERT_TRUE(AreaResizer::suits(image, sizes.to)) << name_of(sizes, channels);
      auto planes = planes_of(sizes.to, channels);
      resizer.run(image, planes);
      cv::Mat expected;
      cv::resize(image, expected, sizes.to, 0, 0, cv::INTER_AREA);
      for (const AreaPlane& plane : planes) {
        cv::Mat one;
        cv::extractChannel(expected, one, plane.channel);
        one.convertTo(one, CV_32F, plane.scale, plane.offset);
        // Means close to a half may round the other way: of 2 x 3 pixels, one mean in six is a half.
        EXPECT_LE(cv::norm(one, plane.pixels, cv::NORM_INF), plane.scale) << name_of(sizes, channels);
        EXPECT_LE(cv::countNonZero(one != plane.pixels), 1 + sizes.to.area() / 6) << name_of(sizes, channels);
      }
    }
}

TEST(AreaResizer, UniformImageKeepsItsValueExactly) {
  AreaResizer resizer;
  for (const Sizes& sizes : kSizes)
    for (const int channels : kChannelCounts) {
      const cv::Mat image(sizes.from, CV_8UC(channels), cv::Scalar(1, 100, 253, 255));
      std::array<AreaPlane, 3> planes = planes_of(sizes.to, channels);
      for (AreaPlane& plane : planes) plane.scale = 1;
      resizer.run(image, planes);
      for (const AreaPlane& plane : planes) {
        const double value = image.ptr()[plane.channel] + plane.offset;
        EXPECT_EQ(cv::countNonZero(plane.pixels != value), 0) << name_of(sizes, channels);
      }
    }
}

TEST(AreaResizer, KeepsTheMeanOfTheImage) {
  AreaResizer resizer;
  for (const Sizes& sizes : kSizes) {
    const cv::Mat image = random_image(sizes.from, 1);
    std::array<AreaPlane, 3> planes = planes_of(sizes.to, 1);
    planes[0].scale = 1;
    resizer.run(image, planes);
    EXPECT_NEAR(cv::mean(planes[0].pixels)[0], cv::mean(image)[0], 0.5) << name_of(sizes, 1);
  }
}

TEST(AreaResizer, WritesNothingOutsideItsPartOfThePlanes) {
  const cv::Rect inside(3, 2, 13, 7);
  AreaResizer resizer;
  for (const int channels : kChannelCounts) {
    const cv::Mat image = random_image({97, 61}, channels);
    std::array<AreaPlane, 3> alone = planes_of(inside.size(), channels);
    std::array<AreaPlane, 3> within = planes_of({20, 12}, channels);
    std::array<cv::Mat, 3> whole;
    for (std::size_t c = 0; c < 3; ++c) {
      whole[c] = within[c].pixels;
      within[c].pixels = whole[c](inside);
    }
    resizer.run(image, alone);
    resizer.run(image, within);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(cv::norm(whole[c](inside), alone[c].pixels, cv::NORM_INF), 0);
      whole[c](inside).setTo(-1e9);
      EXPECT_EQ(cv::countNonZero(whole[c] != -1e9), 0) << channels << " channels";
    }
  }
}

TEST(AreaResizer, LeavesOtherWorkToOpenCv) {
  const auto suits = [](int type, cv::Size to) {
    return AreaResizer::suits(cv::Mat::zeros(48, 64, type), to);
  };
  EXPECT_TRUE(suits(CV_8UC3, {63, 48}));
  EXPECT_FALSE(suits(CV_8UC3, {64, 48})) << "same size";
  EXPECT_FALSE(suits(CV_8UC3, {65, 20})) << "wider";
  EXPECT_FALSE(suits(CV_8UC3, {20, 49})) << "higher";
  EXPECT_FALSE(suits(CV_8UC3, {32, 24})) << "half the size";
  EXPECT_FALSE(suits(CV_16UC1, {20, 20}));
  EXPECT_FALSE(suits(CV_8UC2, {20, 20}));
}

TEST(AreaResizer, PreprocessorLetterboxesWithIt) {
  InputSpec input;
  input.width = 40;
  input.height = 36;
  input.resize = Resize::kLetterbox;
  input.interpolation = Interpolation::kArea;
  input.mean = {10, 20, 30};
  input.scale = {0.5F, 1.0F, 2.0F};
  const cv::Mat image = random_image({97, 61}, 3);
  std::vector<float> planes(3 * 40 * 36, -1e9F);
  Preprocessor preprocessor(input);
  ASSERT_TRUE(preprocessor.run({image.data, 97, 61, image.step, PixelFormat::kBgr8}, planes.data()));

  cv::Mat small;
  cv::resize(image, small, {40, 25}, 0, 0, cv::INTER_AREA);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < 36; ++y)
      for (int x = 0; x < 40; ++x) {
        const bool bar = y < 5 || y >= 30;
        const float value = bar ? 114.0F : static_cast<float>(small.at<cv::Vec3b>(y - 5, x)[2 - c]);
        const auto i = static_cast<std::size_t>(c);
        ASSERT_NEAR(planes[static_cast<std::size_t>((c * 36 + y) * 40 + x)],
                    (value - input.mean[i]) * input.scale[i], bar ? 0 : input.scale[i])
            << c << ' ' << x << ' ' << y;
      }
}

}  // namespace
}  // namespace extperfc::detect

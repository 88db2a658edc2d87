#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/offline/image.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::offline {
namespace {

constexpr Color kWhite = {255, 255, 255};
constexpr Color kRed = {255, 0, 0};

std::size_t count(const Image& image, Color color) {
  std::size_t found = 0;
  for (std::size_t y = 0; y < image.height(); ++y)
    for (std::size_t x = 0; x < image.width(); ++x) found += image.at(x, y) == color ? 1 : 0;
  return found;
}

TEST(Image, DrawsInsideItselfOnly) {
  Image image(10, 5, kWhite);
  image.line(-3, 2, 20, 2, kRed);
  EXPECT_EQ(count(image, kRed), 10U);
  image.disc(0, 0, 1.2, kRed);
  EXPECT_EQ(count(image, kRed), 13U);
  image.rectangle(8, 3, 30, 30, kRed);
  EXPECT_EQ(count(image, kRed), 17U);
  const double nan = std::nan("");
  image.line(nan, 0, 1, 1, kRed);
  image.line(0, 0, 1e300, 1, kRed);
  image.disc(nan, 0, 2, kRed);
  image.set(-1, 0, kRed);
  EXPECT_EQ(count(image, kRed), 17U);
}

TEST(Image, PngFilesHaveTheirSize) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_png(Image(300, 20, kRed), folder.path() / "a.png"));
  std::ifstream in(folder.path() / "a.png", std::ios::binary);
  const std::string png{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(png.substr(16, 10), std::string("\0\0\x01\x2c\0\0\0\x14\x08\x02", 10));  // 300 x 20, 8 bit, RGB
  EXPECT_FALSE(write_png(Image(3, 2, kRed), folder.path() / "none" / "a.png"));
}

OccupancyGrid room() {
  OccupancyGrid map{40, 20, 0.1, {-2, -1, 0}, std::vector<std::int8_t>(800, OccupancyGrid::kFree)};
  for (std::size_t x = 0; x < map.width; ++x) map.cells[x] = OccupancyGrid::kOccupied;  // the lower wall
  return map;
}

TEST(Image, MapsStandUpright) {
  const Image image = draw_map(room(), {});
  EXPECT_EQ(count(image, {0, 0, 0}) >= 40, true);
  // The wall is in the lower half, free space above it.
  std::size_t wall_row = 0;
  for (std::size_t y = 0; y < image.height() / 2 + 5; ++y)
    EXPECT_NE(image.at(image.width() / 2, y), (Color{0, 0, 0})) << y;
  for (std::size_t y = 0; y < image.height(); ++y)
    if (image.at(image.width() - 8, y) == Color{0, 0, 0}) wall_row = y;
  EXPECT_GT(wall_row, image.height() / 2);
}

TEST(Image, PathsHaveAStartAndAnEnd) {
  const Trajectory path = {{0, {-1, 0, 0}}, {1, {1, 0, 0}}};
  const Image image = draw_map(room(), path);
  EXPECT_GT(count(image, {0, 150, 0}), 20U);
  EXPECT_GT(count(image, {220, 0, 0}), 20U);
}

TEST(Image, EmptyAndInvalidInputIsHarmless) {
  EXPECT_GT(draw_map({}, {}).width(), 1U);
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_GT(draw_map({}, {{0, {nan, nan, nan}}, {0, {infinity, 0, 0}}, {0, {1, 1, 0}}}).width(), 1U);
}

TEST(Image, LargeMapsAreMadeSmaller) {
  const Trajectory path = {{0, {-5000, 0, 0}}, {1, {5000, 3000, 0}}};
  const Image image = draw_map({}, path, 1000);
  EXPECT_LE(image.width(), 1002U);
  EXPECT_GT(image.width(), 400U);
  EXPECT_LT(image.height(), image.width());
  const Image small = draw_map(room(), {}, 10);
  EXPECT_LE(small.width(), 12U);
  EXPECT_GT(count(small, {0, 0, 0}), 3U) << "walls survive";
}

TEST(Image, BadRelationsAreRed) {
  const std::vector<std::optional<Pose2>> poses = {Pose2{0, 0, 0}, Pose2{3, 0, 0}, Pose2{3, 3, 0},
                                                   std::nullopt};
  const std::vector<Relation> relations = {{0, 1, {3, 0, 0}}, {0, 2, {3, 4, 0}}, {0, 3, {}}};
  const auto score = score_relations(relations, poses);
  const Image image = draw_relations({}, poses, relations, score);
  EXPECT_GT(count(image, {0, 170, 0}), 40U);
  EXPECT_GT(count(image, {230, 0, 0}), 60U);
}

}  // namespace
}  // namespace extperfc::offline

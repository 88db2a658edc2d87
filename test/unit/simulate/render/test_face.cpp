// Faces of people: where they are, how they differ, what they cost.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "simulate/render/face_texture.hpp"
#include "simulate/render/stage.hpp"
#include "test/unit/simulate/render/face_camera.hpp"

namespace extperfc::simulate {
namespace {

constexpr int kSeeds = 12;
constexpr int kEye_px = 3;  // from the pupil to the white of an eye at 1 m

PersonSpec named(const std::string& name) {
  PersonSpec person;
  person.name = name;
  person.path_m = {{0, 0}};
  return person;
}

WorldSpec crowd(int people, bool same_face) {
  WorldSpec world;
  for (int i = 0; i < people; ++i) {
    world.people.push_back(named("p" + std::to_string(i)));
    world.people.back().face = same_face ? 5 : i;
  }
  return world;
}

/// Differences of colours between two textures on the face, mean over pixels and channels.
double front_difference(const MipTexture& a, const MipTexture& b) {
  const Eigen::Vector2i low = (face_texture_at(-0.45F, 0.30F) * MipTexture::kSize).cast<int>();
  const Eigen::Vector2i high = (face_texture_at(0.45F, -0.80F) * MipTexture::kSize).cast<int>();
  double sum = 0;
  for (int y = low.y(); y < high.y(); ++y)
    for (int x = low.x(); x < high.x(); ++x)
      for (int shift = 0; shift < 24; shift += 8) {
        const auto i = static_cast<std::size_t>(y * MipTexture::kSize + x);
        sum += std::abs(static_cast<int>(a.pixels[i] >> shift & 0xFFU) -
                        static_cast<int>(b.pixels[i] >> shift & 0xFFU));
      }
  return sum / (3.0 * (high - low).prod());
}

/// Brightest minus darkest green value within `radius` pixels.
int contrast(const CameraImages& images, const Eigen::Vector2d& centre, int radius) {
  int low = 255;
  int high = 0;
  for (int y = -radius; y <= radius; ++y)
    for (int x = -radius; x <= radius; ++x) {
      const auto row = static_cast<int>(std::lround(centre.y())) + y;
      const auto column = static_cast<int>(std::lround(centre.x())) + x;
      const int green = images.rgb[static_cast<std::size_t>(3 * (row * images.width + column) + 1)];
      low = std::min(low, green);
      high = std::max(high, green);
    }
  return high - low;
}

TEST(Face, SameSeedIsTheSameFace) {
  for (int seed = 0; seed < 3; ++seed) {
    EXPECT_EQ(make_face_texture(face_features(seed)).pixels, make_face_texture(face_features(seed)).pixels);
    EXPECT_EQ(face_landmarks(face_features(seed)), face_landmarks(face_features(seed)));
  }
}

TEST(Face, SeedsDifferInTextureAndShape) {
  std::vector<MipTexture> textures;
  for (int seed = 0; seed < kSeeds; ++seed) textures.push_back(make_face_texture(face_features(seed)));
  for (int a = 0; a < kSeeds; ++a)
    for (int b = 0; b < a; ++b) {
      EXPECT_GT(front_difference(textures[a], textures[b]), 6.0) << a << ", " << b;
      const auto first = face_landmarks(face_features(a));
      const auto second = face_landmarks(face_features(b));
      float largest = 0;
      for (std::size_t i = 0; i < first.size(); ++i)
        largest = std::max(largest, (first[i] - second[i]).norm());
      EXPECT_GT(largest, 0.001F) << a << ", " << b;
    }
}

TEST(Face, LandmarksAreWhereAFaceHasThem) {
  for (int seed = 0; seed < 200; ++seed) {
    const auto mark = face_landmarks(face_features(seed));
    for (const auto& one : mark) EXPECT_GT(one.x(), 0.06F) << "on the front, seed " << seed;
    EXPECT_NEAR((mark[1] - mark[0]).norm(), 0.063F, 0.010F) << "between the eyes, seed " << seed;
    EXPECT_LT(mark[0].y(), 0.0F) << "the person's right";
    EXPECT_GT(mark[2].x(), mark[0].x() + 0.015F) << "the nose is before the eyes";
    EXPECT_GT(mark[2].z(), mark[3].z() + 0.015F) << "and above the mouth";
    EXPECT_LT(mark[3].y(), mark[4].y());
  }
}

TEST(Face, RenderedSurfaceIsAtTheLandmarks) {
  for (const int seed : {0, 3, 8}) {
    FaceCamera camera(seed);
    const CameraImages& images = camera.look(0.6, 0.2);
    for (const auto& point : camera.landmarks()) {
      const Eigen::Vector2d pixel = camera.project(point);
      const auto i = static_cast<std::size_t>(std::lround(pixel.y()) * images.width + std::lround(pixel.x()));
      EXPECT_NEAR(images.true_depth_m[i], point.z(), 0.004) << "seed " << seed;
    }
  }
}

TEST(Face, EyesAreOnTheFrontOnly) {
  for (const int seed : {0, 4, 7, 10}) {
    FaceCamera camera(seed);
    const CameraImages& front = camera.look(1.0, 0.0);
    const auto marks = camera.landmarks();
    for (const int eye : {0, 1}) EXPECT_GT(contrast(front, camera.project(marks[eye]), kEye_px), 60) << seed;
    const CameraImages& back = camera.look(1.0, M_PI);
    for (const int eye : {0, 1}) EXPECT_LT(contrast(back, camera.project(marks[eye]), kEye_px), 60) << seed;
  }
}

TEST(Face, TextureCoordinatesAndAzimuthsAreInverse) {
  for (float azimuth = -3.1F; azimuth < 3.1F; azimuth += 0.1F)
    EXPECT_NEAR(face_texture_azimuth(face_texture_at(azimuth, 0).x()), azimuth, 1e-4F);
  EXPECT_FLOAT_EQ(face_texture_at(0, 0).x(), 0.5F);
}

TEST(Face, SeedComesFromTheNameUnlessItIsGiven) {
  EXPECT_EQ(face_seed(named("anna")), face_seed(named("anna")));
  std::set<int> seeds;
  for (const char* name : {"anna", "ben", "carla", "dora", "emil", "person_1", "person_2", ""}) {
    const int seed = face_seed(named(name));
    EXPECT_GE(seed, 0);
    EXPECT_LE(seed, kMaxFaceSeed);
    seeds.insert(seed);
  }
  EXPECT_EQ(seeds.size(), 8U);
  PersonSpec person = named("anna");
  person.face = 3;
  EXPECT_EQ(face_seed(person), 3);
}

TEST(Face, MemoryIsBounded) {
  const auto pixels = static_cast<std::size_t>(MipTexture::first_pixel(1)) + 1;
  EXPECT_LE(pixels * sizeof(std::uint32_t) * kMaxFaces, 100'000'000U);
  EXPECT_EQ(make_face_texture(face_features(1)).pixels.size(), pixels);
  const auto twins = build_stage(RobotModel{}, crowd(static_cast<int>(kMaxFaces) + 6, true));
  ASSERT_TRUE(twins) << twins.error().message;
  EXPECT_EQ(twins->faces.size(), 1U) << "people with the same face have one texture";
  EXPECT_TRUE(build_stage(RobotModel{}, crowd(0, true))->faces.empty());
}

TEST(Face, TooManyDifferentFacesAreRefusedWithARemedy) {
  const auto stage = build_stage(RobotModel{}, crowd(static_cast<int>(kMaxFaces) + 1, false));
  ASSERT_FALSE(stage);
  EXPECT_EQ(stage.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(stage.error().message.find("person p64"), std::string::npos) << stage.error().message;
  EXPECT_NE(stage.error().message.find("same `face`"), std::string::npos) << stage.error().message;
}

TEST(Face, OnlyTheHeadHasTheTextureOfTheFace) {
  const auto stage = build_stage(RobotModel{}, crowd(2, false));
  ASSERT_TRUE(stage);
  for (const int seed : {0, 1}) {
    const std::uint32_t* pixels = stage->faces.at(seed).pixels.data();
    EXPECT_EQ(std::count_if(stage->surfaces.begin(), stage->surfaces.end(),
                            [&](const TriangleSurface& surface) { return surface.texture == pixels; }),
              1);
  }
}

}  // namespace
}  // namespace extperfc::simulate

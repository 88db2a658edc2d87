// Similarities from landmarks, and faces cut out with them.
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/face/alignment.hpp"

namespace extperfc::face {
namespace {

Eigen::Affine2d similarity_of(double scale, double angle, const Eigen::Vector2d& offset) {
  Eigen::Affine2d transform = Eigen::Affine2d::Identity();
  transform.linear() = scale * Eigen::Rotation2Dd(angle).toRotationMatrix();
  transform.translation() = offset;
  return transform;
}

Landmarks transformed(const Landmarks& points, const Eigen::Affine2d& transform) {
  Landmarks result;
  for (std::size_t i = 0; i < points.size(); ++i)
    result[i] = (transform * points[i].cast<double>()).cast<float>();
  return result;
}

double squared_distances(const Landmarks& from, const Landmarks& to, const Eigen::Affine2d& transform) {
  double sum = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i)
    sum += (transform * from[i].cast<double>() - to[i].cast<double>()).squaredNorm();
  return sum;
}

TEST(FitSimilarity, FindsTheOneThatMovedThePoints) {
  Rng rng(11);
  for (int i = 0; i < 200; ++i) {
    const auto truth = similarity_of(rng.uniform(0.1, 8), rng.uniform(-M_PI, M_PI),
                                     {rng.uniform(-200, 200), rng.uniform(-200, 200)});
    const auto found = fit_similarity(reference_landmarks(), transformed(reference_landmarks(), truth));
    ASSERT_TRUE(found) << i;
    EXPECT_TRUE(found->matrix().isApprox(truth.matrix(), 1e-5)) << i << '\n' << found->matrix();
  }
}

TEST(FitSimilarity, NoOtherSimilarityIsNearer) {
  Rng rng(12);
  Landmarks moved = transformed(reference_landmarks(), similarity_of(2, 0.4, {30, -10}));
  for (auto& point : moved) point += Eigen::Vector2f(static_cast<float>(rng.uniform(-5, 5)), 0);
  const auto best = fit_similarity(reference_landmarks(), moved);
  ASSERT_TRUE(best);
  const double min_sum = squared_distances(reference_landmarks(), moved, *best);
  for (int i = 0; i < 200; ++i) {
    const auto nearby = similarity_of(1 + rng.uniform(-0.01, 0.01), rng.uniform(-0.01, 0.01),
                                      {rng.uniform(-1, 1), rng.uniform(-1, 1)});
    EXPECT_LE(min_sum, squared_distances(reference_landmarks(), moved, nearby * *best) + 1e-9) << i;
  }
}

TEST(FitSimilarity, MirroredPointsAreNotMirroredBack) {
  Landmarks mirrored = reference_landmarks();
  for (auto& point : mirrored) point.x() = -point.x();
  const auto found = fit_similarity(mirrored, reference_landmarks());
  ASSERT_TRUE(found);
  EXPECT_GT(found->linear().determinant(), 0);
}

TEST(FitSimilarity, PointsThatCoincideOrAreNotFiniteHaveNone) {
  Landmarks one_place;
  one_place.fill(Eigen::Vector2f(3, 4));
  EXPECT_FALSE(fit_similarity(one_place, reference_landmarks()));
  EXPECT_FALSE(fit_similarity(reference_landmarks(), one_place)) << "a scale of 0 shows nothing";
  Landmarks wild = reference_landmarks();
  wild[2].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(fit_similarity(wild, reference_landmarks()));
}

/// Red grows with x, green with y: a pixel says where it is.
std::vector<std::uint8_t> position_image(int size) {
  std::vector<std::uint8_t> rgb;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      for (const int value : {x, y, 0}) rgb.push_back(static_cast<std::uint8_t>(value));
  return rgb;
}

TEST(Align, PixelsComeFromWhereTheLandmarksAre) {
  constexpr int kSize = 240;
  const auto rgb = position_image(kSize);
  const ImageView image{rgb.data(), kSize, kSize, 3 * kSize, PixelFormat::kRgb8};
  const auto image_T_aligned = similarity_of(1.2, 0.3, {60, 30});
  const auto faces = align(image, {transformed(reference_landmarks(), image_T_aligned)});
  ASSERT_TRUE(faces) << faces.error().message;
  ASSERT_TRUE(faces->front());
  const ImageView aligned = faces->front()->view();
  EXPECT_EQ(aligned.width, kAlignedSize);
  EXPECT_EQ(aligned.format, PixelFormat::kBgr8);
  for (int y = 5; y < kAlignedSize; y += 17)
    for (int x = 5; x < kAlignedSize; x += 17) {
      const Eigen::Vector2d source = image_T_aligned * Eigen::Vector2d(x, y);
      EXPECT_NEAR(aligned.row(y)[3 * x + 2], source.x(), 1.0) << x << ' ' << y;
      EXPECT_NEAR(aligned.row(y)[3 * x + 1], source.y(), 1.0) << x << ' ' << y;
    }
}

TEST(Align, OutsideTheImageIsBlackAndWhatCannotBeAlignedIsEmpty) {
  const auto rgb = position_image(64);
  const ImageView image{rgb.data(), 64, 64, 3 * 64, PixelFormat::kRgb8};
  Landmarks one_place;
  one_place.fill(Eigen::Vector2f(3, 4));
  const auto faces =
      align(image, {one_place, transformed(reference_landmarks(), similarity_of(1, 0, {500, 500}))});
  ASSERT_TRUE(faces) << faces.error().message;
  EXPECT_FALSE((*faces)[0]);
  ASSERT_TRUE((*faces)[1]);
  for (const auto value : (*faces)[1]->bgr) ASSERT_EQ(value, 0);
  EXPECT_EQ(align({}, {reference_landmarks()}).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace extperfc::face

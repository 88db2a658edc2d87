// Positions of all boxes of an image, with and without shapes that are known.
#include <optional>

#include <gtest/gtest.h>

#include "extperfc/depth/locate_boxes.hpp"

#include "test/unit/depth/standing_object.hpp"

namespace extperfc::depth {
namespace {

constexpr Box2 kNowhere{5000, 5000, 5020, 5020};

class LocateBoxes : public testing::Test {
 protected:
  /// The sphere as class 2, and a box beside the image as class 0.
  [[nodiscard]] LocatedBoxes located(const ShapesToFit& shapes) const {
    return locate_boxes({{0, 0.9F, kNowhere}, {2, 0.8F, view_.box}}, view_.depth.view(), fit_camera(), {},
                        shapes);
  }

  Rng rng_{5};
  Standing sphere_{FitShape::kSphere, 0.06, 0.06, 0};
  View view_{view_of(sphere_, 0.5, 0.8, rng_, std::nullopt)};
};

TEST_F(LocateBoxes, BoxesWithoutDepthAreCounted) {
  const auto found = located({});
  EXPECT_EQ(found.without_depth, 1);
  EXPECT_EQ(found.not_fitted, 0);
  ASSERT_EQ(found.boxes.size(), 1U);
  const auto& box = found.boxes.front();
  EXPECT_EQ(box.detection.class_index, 2);
  EXPECT_FALSE(box.fit);
  const auto estimate = estimate_depth(view_.depth.view(), view_.box, {});
  ASSERT_TRUE(estimate);
  EXPECT_EQ(box.object.center, locate(fit_camera(), view_.box, *estimate).center);
}

TEST_F(LocateBoxes, AShapeIsFittedToItsClass) {
  const auto found = located({{FitShape::kCube, std::nullopt, FitShape::kSphere}, view_.up()});
  ASSERT_EQ(found.boxes.size(), 1U);
  ASSERT_TRUE(found.boxes.front().fit);
  const auto& fit = *found.boxes.front().fit;
  EXPECT_LT((fit.camera_T_object.translation() - view_.middle(sphere_)).norm(), 1e-3);
  EXPECT_NEAR(fit.size_m.x(), sphere_.width_m, 2e-3);
  EXPECT_EQ(found.not_fitted, 0);
}

TEST_F(LocateBoxes, OtherClassesHaveNoShape) {
  for (const auto& of_class : {std::vector<std::optional<FitShape>>{FitShape::kSphere, FitShape::kSphere},
                               {std::nullopt, std::nullopt, std::nullopt, FitShape::kSphere}}) {
    const auto found = located({of_class, view_.up()});
    ASSERT_EQ(found.boxes.size(), 1U);
    EXPECT_FALSE(found.boxes.front().fit);
    EXPECT_EQ(found.not_fitted, 0);
  }
  // A detection without a class.
  const auto found = locate_boxes({{-1, 0.8F, view_.box}}, view_.depth.view(), fit_camera(), {},
                                  {{FitShape::kSphere}, view_.up()});
  ASSERT_EQ(found.boxes.size(), 1U);
  EXPECT_FALSE(found.boxes.front().fit);
}

TEST_F(LocateBoxes, AShapeThatDoesNotFitIsCounted) {
  const Eigen::Vector3d sideways = view_.up().unitOrthogonal();  // no support has this normal
  const auto found = located({{std::nullopt, std::nullopt, FitShape::kSphere}, sideways});
  ASSERT_EQ(found.boxes.size(), 1U);
  EXPECT_FALSE(found.boxes.front().fit);
  EXPECT_EQ(found.not_fitted, 1);
}

}  // namespace
}  // namespace extperfc::depth

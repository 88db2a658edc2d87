// Suppression, and what is no face detector.
#include <filesystem>

#include <gtest/gtest.h>

#include "extperfc/face/face_detector.hpp"

namespace extperfc::face {
namespace {

DetectedFace face_at(float x, float score) {
  return {{x, 0, x + 10, 10}, {}, score};
}

detect::Thresholds thresholds(int max_detections = 100) {
  return {0.5F, 0.3F, max_detections};
}

TEST(Suppress, TheBetterOfTwoThatOverlapStays) {
  const auto kept = suppress({face_at(0, 0.6F), face_at(2, 0.9F), face_at(50, 0.7F)}, thresholds());
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[0].score, 0.9F);
  EXPECT_EQ(kept[1].score, 0.7F);
}

TEST(Suppress, AnOverlapUpToTheLimitIsAllowed) {
  // 10 x 10 boxes at 0 and 5.4: iou 46 / 154 = 0.2987; at 5.3: 47 / 153 = 0.307.
  EXPECT_EQ(suppress({face_at(0, 0.6F), face_at(5.4F, 0.9F)}, thresholds()).size(), 2U);
  EXPECT_EQ(suppress({face_at(0, 0.6F), face_at(5.3F, 0.9F)}, thresholds()).size(), 1U);
}

TEST(Suppress, AFaceThatIsLeftOutSuppressesNoOther) {
  // Each overlaps the next; the middle one falls to the first.
  EXPECT_EQ(suppress({face_at(0, 0.9F), face_at(4, 0.8F), face_at(8, 0.7F)}, thresholds()).size(), 2U);
}

TEST(Suppress, TheBestAreKept) {
  const auto kept = suppress({face_at(0, 0.6F), face_at(50, 0.8F), face_at(90, 0.7F)}, thresholds(2));
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_EQ(kept[1].score, 0.7F);
}

TEST(FaceDetector, AModelForObjectsIsRefused) {
  const auto spec = detect::load_model_spec(std::filesystem::path(EXTPERFC_TEST_DATA) / "models/square");
  ASSERT_TRUE(spec) << spec.error().message;
  const auto detector = FaceDetector::create(*spec, {});
  ASSERT_FALSE(detector);
  EXPECT_EQ(detector.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(detector.error().message.find("layout yunet"), std::string::npos) << detector.error().message;
}

}  // namespace
}  // namespace extperfc::face

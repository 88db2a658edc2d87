#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/detect/decode.hpp"

namespace extperfc::detect {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

float logit(float p) {
  return std::log(p / (1.0F - p));
}

/// Two classes, input 100 x 50.
ModelSpec make_spec(OutputLayout layout) {
  ModelSpec spec;
  spec.name = "test";
  spec.input.width = 100;
  spec.input.height = 50;
  spec.output.layout = layout;
  spec.output.names = {"first", "second"};
  spec.classes = {"cone", "cube"};
  return spec;
}

TensorView view(std::vector<int> shape, const std::vector<float>& values) {
  TensorView tensor{std::move(shape), values.data()};
  EXPECT_EQ(tensor.size(), values.size());
  return tensor;
}

/// check_outputs() must agree, then decode().
Detections decoded(const ModelSpec& spec, const std::vector<TensorView>& outputs) {
  const auto checked = check_outputs(spec, outputs);
  EXPECT_TRUE(checked) << checked.error().message;
  return checked ? decode(spec, outputs) : Detections{};
}

void expect_detection(const Detection& actual, int class_index, float score, const Box2& box) {
  EXPECT_EQ(actual.class_index, class_index);
  EXPECT_NEAR(actual.score, score, 1e-5F);
  EXPECT_NEAR(actual.box.x_min, box.x_min, 1e-3F);
  EXPECT_NEAR(actual.box.y_min, box.y_min, 1e-3F);
  EXPECT_NEAR(actual.box.x_max, box.x_max, 1e-3F);
  EXPECT_NEAR(actual.box.y_max, box.y_max, 1e-3F);
}

TEST(DecodeSsd, CornersBecomePixelsAndTheBackgroundIsSkipped) {
  ModelSpec spec = make_spec(OutputLayout::kSsd);
  spec.output.background_class = 0;
  const std::vector<float> boxes{0.1F, 0.2F, 0.5F, 0.6F, 0.0F, 0.0F, 1.0F, 1.0F};
  const std::vector<float> scores{0.1F, 0.2F, 0.7F, 0.9F, 0.05F, 0.05F};
  const auto found = decoded(spec, {view({1, 2, 4}, boxes), view({1, 2, 3}, scores)});
  ASSERT_EQ(found.size(), 1U);
  expect_detection(found[0], 1, 0.7F, {10, 10, 50, 30});
}

TEST(DecodeSsd, BackgroundInTheMiddleShiftsOnlyLaterClasses) {
  ModelSpec spec = make_spec(OutputLayout::kSsd);
  spec.output.background_class = 1;
  const std::vector<float> boxes{0, 0, 1, 1, 0, 0, 1, 1};
  const std::vector<float> scores{0.8F, 0.1F, 0.1F, 0.1F, 0.2F, 0.6F};
  const auto found = decoded(spec, {view({2, 4}, boxes), view({2, 3}, scores)});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].class_index, 0);
  EXPECT_EQ(found[1].class_index, 1);
}

TEST(DecodeSsd, SoftmaxOfLogits) {
  ModelSpec spec = make_spec(OutputLayout::kSsd);
  spec.output.background_class = 0;
  spec.output.apply_softmax = true;
  const std::vector<float> boxes{0, 0, 0.5F, 0.5F, 0, 0, 1, 1, 0, 0, 1, 1};
  // Logarithms of 1 : 1 : 6 (score 0.75), of 6 : 1 : 1 (background), and a row with NaN.
  const float six = std::log(6.0F);
  const std::vector<float> logits{0, 0, six, six, 0, 0, 0, kNan, 1};
  const auto found = decoded(spec, {view({3, 4}, boxes), view({3, 3}, logits)});
  ASSERT_EQ(found.size(), 1U);
  expect_detection(found[0], 1, 0.75F, {0, 0, 50, 25});
}

TEST(DecodeSsd, SoftmaxShortcutDropsNothingAboveTheThreshold) {
  ModelSpec spec = make_spec(OutputLayout::kSsd);
  spec.output.background_class = 0;
  const std::vector<float> boxes{0, 0, 1, 1};
  for (float cone = -3; cone <= 3; cone += 0.25F)
    for (float cube = -3; cube <= 3; cube += 0.25F)
      for (const float threshold : {0.0F, 0.05F, 0.3F, 0.5F, 0.9F, 1.0F}) {
        const std::vector<float> logits{0, cone, cube};
        const float sum = 1 + std::exp(cone) + std::exp(cube);
        const std::vector<float> scores{1 / sum, std::exp(cone) / sum, std::exp(cube) / sum};
        spec.thresholds.score = threshold;
        spec.output.apply_softmax = true;
        const auto fast = decoded(spec, {view({1, 4}, boxes), view({1, 3}, logits)});
        spec.output.apply_softmax = false;
        const auto plain = decoded(spec, {view({1, 4}, boxes), view({1, 3}, scores)});
        EXPECT_EQ(fast.size(), plain.size()) << cone << ' ' << cube << ' ' << threshold;
      }
}

TEST(DecodeSsdPriors, OffsetsMoveAndStretchThePrior) {
  ModelSpec spec = make_spec(OutputLayout::kSsdPriors);
  spec.output.priors = {{0.5F, 0.5F, 0.2F, 0.4F}, {0.5F, 0.5F, 0.2F, 0.4F}};
  // Centre + 1 * 0.1 * size, width * exp(ln 2 / 0.2 * 0.2).
  const std::vector<float> offsets{0, 0, 0, 0, 1, -1, std::log(2.0F) / 0.2F, 0};
  const std::vector<float> scores{0.9F, 0, 0, 0.8F};
  const auto found = decoded(spec, {view({1, 2, 4}, offsets), view({1, 2, 2}, scores)});
  ASSERT_EQ(found.size(), 2U);
  expect_detection(found[0], 0, 0.9F, {40, 15, 60, 35});
  expect_detection(found[1], 1, 0.8F, {32, 13, 72, 33});
}

TEST(DecodeYoloV7, ScoreIsObjectnessTimesBestClass) {
  const ModelSpec spec = make_spec(OutputLayout::kYoloV7);
  const std::vector<float> rows{50, 20, 10,        6, 0.9F, 0.1F, 0.8F,  //
                                50, 20, 10,        6, 0.9F, 0.1F, 0.5F,  // 0.45: below
                                50, 20, 10,        6, kNan, 1.0F, 1.0F,  //
                                50, 20, kInfinity, 6, 1,    1.0F, 0,     //
                                50, 20, -4,        6, 1,    1.0F, 0};
  const auto found = decoded(spec, {view({1, 5, 7}, rows)});
  ASSERT_EQ(found.size(), 1U);
  expect_detection(found[0], 1, 0.72F, {45, 17, 55, 23});
}

TEST(DecodeYoloV8, ColumnsAreCandidatesAndOnlyTheBestClassCounts) {
  const ModelSpec spec = make_spec(OutputLayout::kYoloV8);
  constexpr int kCount = 131;  // two whole blocks of the scan and a rest
  std::vector<float> tensor(6 * kCount, 0.0F);
  const auto set = [&tensor](int column, const std::vector<float>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      tensor[i * kCount + static_cast<std::size_t>(column)] = values[i];
  };
  set(0, {20, 20, 10, 10, 0.5F, 0});  // exactly at the threshold
  set(70, {50, 25, 20, 10, 0.6F, 0.7F});
  set(130, {80, 40, 10, 20, 0.9F, 0});
  set(3, {80, 40, 10, 20, kNan, kNan});
  set(4, {80, kNan, 10, 20, 0.9F, 0});
  const auto found = decoded(spec, {view({1, 6, kCount}, tensor)});
  ASSERT_EQ(found.size(), 3U);
  expect_detection(found[0], 0, 0.5F, {15, 15, 25, 25});
  expect_detection(found[1], 0, 0.9F, {75, 30, 85, 50});
  expect_detection(found[2], 1, 0.7F, {40, 20, 60, 30});
}

TEST(DecodeYoloAnchors, SecondAnchorOfSecondLevel) {
  ModelSpec spec = make_spec(OutputLayout::kYoloAnchors);
  spec.input.width = 64;
  spec.input.height = 32;
  spec.output.anchors = {{16, {{10, 10}}}, {32, {{10, 20}, {30, 40}}}};
  const std::vector<float> fine(7 * 4 * 2, -10.0F);
  std::vector<float> coarse(2 * 7 * 2, -10.0F);  // two anchors, 7 planes of 2 x 1 cells
  const auto plane = [&coarse](std::size_t k) -> float& {
    return coarse[(7 + k) * 2 + 1];
  };                        // anchor 1, cell (1, 0)
  plane(0) = 0;             // centre x = (2 * 0.5 - 0.5 + 1) * 32 = 48
  plane(1) = logit(0.25F);  // centre y = (0.5 - 0.5 + 0) * 32 = 0
  plane(2) = 0;             // width = (2 * 0.5)^2 * 30
  plane(3) = logit(0.75F);  // height = 1.5^2 * 40
  plane(4) = logit(0.9F);
  plane(6) = logit(0.8F);
  const auto found = decoded(spec, {view({1, 7, 2, 4}, fine), view({1, 14, 1, 2}, coarse)});
  ASSERT_EQ(found.size(), 1U);
  expect_detection(found[0], 1, 0.72F, {33, -45, 63, 45});
}

TEST(DecodeYoloGrid, FastestDetFormulas) {
  const ModelSpec spec = make_spec(OutputLayout::kYoloGrid);
  std::vector<float> head(7 * 2 * 4, 0.0F);  // 4 x 2 cells of 25 x 25 pixels
  const auto plane = [&head](std::size_t k) -> float& { return head[k * 8 + 6]; };  // cell (2, 1)
  plane(0) = 0.9F;
  plane(1) = std::atanh(0.2F);
  plane(2) = std::atanh(-0.4F);
  plane(3) = logit(0.3F);
  plane(4) = logit(0.6F);
  plane(5) = 0.8F;
  const auto found = decoded(spec, {view({1, 7, 2, 4}, head)});
  ASSERT_EQ(found.size(), 1U);
  expect_detection(found[0], 0, std::pow(0.9F, 0.6F) * std::pow(0.8F, 0.4F), {40, 0, 70, 30});
}

TEST(Decode, ThresholdsOfZeroAndOneAreFine) {
  ModelSpec spec = make_spec(OutputLayout::kYoloAnchors);
  spec.input.width = spec.input.height = 32;
  spec.output.anchors = {{32, {{10, 10}}}};
  const std::vector<float> head{0, 0, 0, 0, 100, -100, 100};
  for (const float threshold : {0.0F, 1.0F}) {
    spec.thresholds.score = threshold;
    EXPECT_EQ(decoded(spec, {view({1, 7, 1, 1}, head)}).size(), 1U) << threshold;
  }
}

TEST(CheckOutputs, SaysTensorShapeAndExpectation) {
  const std::vector<float> values(100);
  const ModelSpec v8 = make_spec(OutputLayout::kYoloV8);
  const auto error = check_outputs(v8, {{{1, 84, 100}, values.data()}}).error();
  EXPECT_EQ(error.code, ErrorCode::kInvalidArgument);
  for (const char* part : {"\"first\"", "[1, 84, 100]", "[6, N]", "yolo_v8", "2 classes"})
    EXPECT_NE(error.message.find(part), std::string::npos) << part << " in: " << error.message;
}

TEST(CheckOutputs, RefusesWrongCountsRanksAndPairs) {
  const std::vector<float> values(100);
  const auto tensor = [&values](std::vector<int> shape) {
    return TensorView{std::move(shape), values.data()};
  };
  const ModelSpec ssd = make_spec(OutputLayout::kSsd);
  EXPECT_TRUE(check_outputs(ssd, {tensor({1, 8, 4}), tensor({1, 8, 2})}));
  EXPECT_FALSE(check_outputs(ssd, {tensor({1, 8, 4})}));
  EXPECT_FALSE(check_outputs(ssd, {tensor({1, 8, 4}), tensor({1, 8, 3})}));
  EXPECT_FALSE(check_outputs(ssd, {tensor({1, 8, 4}), tensor({1, 7, 2})}));
  EXPECT_FALSE(check_outputs(ssd, {tensor({2, 8, 4}), tensor({2, 8, 2})}));
  EXPECT_FALSE(check_outputs(ssd, {tensor({1, 0, 4}), tensor({1, 0, 2})}));
  ModelSpec priors = make_spec(OutputLayout::kSsdPriors);
  priors.output.priors.resize(7);
  EXPECT_FALSE(check_outputs(priors, {tensor({1, 8, 4}), tensor({1, 8, 2})}));
  EXPECT_FALSE(check_outputs(make_spec(OutputLayout::kYoloGrid), {tensor({1, 7, 8})}));
}

}  // namespace
}  // namespace extperfc::detect

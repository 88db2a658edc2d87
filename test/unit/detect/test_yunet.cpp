// Decoding of YuNet's tensors, against values worked out by hand.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/detect/decode.hpp"
#include "extperfc/detect/detector.hpp"
#include "extperfc/detect/yunet.hpp"

#include "test/support/temporary_folder.hpp"

namespace extperfc::detect {
namespace {

constexpr int kWidth = 96;   // 12, 6 and 3 cells
constexpr int kHeight = 64;  // 8, 4 and 2 cells
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

ModelSpec yunet_spec() {
  ModelSpec spec;
  spec.name = "test";
  spec.input.width = kWidth;
  spec.input.height = kHeight;
  spec.output.layout = OutputLayout::kYunet;
  spec.classes = {"face"};
  return spec;
}

/// The twelve tensors, all zero: no face anywhere.
class Tensors {
 public:
  Tensors() {
    for (const int numbers : {1, 1, 4, 10})
      for (const int stride : {8, 16, 32}) {
        const int cells = (kWidth / stride) * (kHeight / stride);
        shapes_.push_back({1, cells, numbers});
        values_.emplace_back(static_cast<std::size_t>(cells * numbers), 0.0F);
      }
  }

  /// Level 0, 1 or 2.
  void set(std::size_t level, int cell, float cls, float obj, const std::vector<float>& bbox,
           const std::vector<float>& kps) {
    const auto at = static_cast<std::size_t>(cell);
    values_[level][at] = cls;
    values_[3 + level][at] = obj;
    std::copy(bbox.begin(), bbox.end(), values_[6 + level].begin() + 4 * cell);
    std::copy(kps.begin(), kps.end(), values_[9 + level].begin() + 10 * cell);
  }

  [[nodiscard]] std::vector<TensorView> views() const {
    std::vector<TensorView> views;
    for (std::size_t i = 0; i < values_.size(); ++i) views.push_back({shapes_[i], values_[i].data()});
    return views;
  }

 private:
  std::vector<std::vector<int>> shapes_;
  std::vector<std::vector<float>> values_;
};

const std::vector<float> kBox{0.5F, 0.25F, std::log(2.0F), std::log(3.0F)};
const std::vector<float> kPoints{0, 0, 1, 0, 0.5F, 0.5F, 0, 1, 1, 1};

TEST(Yunet, BoxAndLandmarksAreRelativeToTheCell) {
  Tensors tensors;
  tensors.set(1, 2 * 6 + 4, 0.81F, 1.0F, kBox, kPoints);  // column 4, row 2 of stride 16
  const auto spec = yunet_spec();
  ASSERT_TRUE(check_outputs(spec, tensors.views()));
  const auto found = decode_yunet(spec, tensors.views());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].detection.score, 0.9F, 1e-6F);
  EXPECT_EQ(found[0].detection.class_index, 0);
  // Centre (4.5, 2.25) * 16 = (72, 36); size (2, 3) * 16 = (32, 48).
  EXPECT_NEAR(found[0].detection.box.x_min, 56.0F, 1e-3F);
  EXPECT_NEAR(found[0].detection.box.y_min, 12.0F, 1e-3F);
  EXPECT_NEAR(found[0].detection.box.x_max, 88.0F, 1e-3F);
  EXPECT_NEAR(found[0].detection.box.y_max, 60.0F, 1e-3F);
  EXPECT_TRUE(found[0].landmarks[0].isApprox(Eigen::Vector2f(64, 32)));
  EXPECT_TRUE(found[0].landmarks[1].isApprox(Eigen::Vector2f(80, 32)));
  EXPECT_TRUE(found[0].landmarks[2].isApprox(Eigen::Vector2f(72, 40)));
  EXPECT_TRUE(found[0].landmarks[4].isApprox(Eigen::Vector2f(80, 48)));
  const auto boxes = decode(spec, tensors.views());
  ASSERT_EQ(boxes.size(), 1U) << "a Detector gets the boxes";
  EXPECT_EQ(boxes[0].box.x_min, found[0].detection.box.x_min);
}

TEST(Yunet, EveryStrideHasItsCells) {
  for (const std::size_t level : {0U, 1U, 2U}) {
    Tensors tensors;
    const auto stride = static_cast<float>(8 << level);
    const int columns = kWidth / (8 << level);
    tensors.set(level, columns + 1, 1.0F, 1.0F, {0, 0, 0, 0}, kPoints);  // column 1, row 1
    const auto found = decode_yunet(yunet_spec(), tensors.views());
    ASSERT_EQ(found.size(), 1U) << level;
    EXPECT_EQ(found[0].detection.box.center_x(), stride);
    EXPECT_EQ(found[0].detection.box.center_y(), stride);
    EXPECT_EQ(found[0].detection.box.width(), stride);
  }
}

TEST(Yunet, ProbabilitiesAreLimitedAndWildValuesLeftOut) {
  Tensors tensors;
  tensors.set(0, 0, 4.0F, 1.0F, kBox, kPoints);  // more than 1
  tensors.set(0, 1, kNan, 1.0F, kBox, kPoints);
  tensors.set(0, 2, -1.0F, -1.0F, kBox, kPoints);           // a positive product
  tensors.set(0, 3, 1.0F, 1.0F, {0, 0, 1000, 0}, kPoints);  // infinite width
  tensors.set(0, 4, 1.0F, 1.0F, kBox, {0, 0, kNan, 0, 0, 0, 0, 0, 0, 0});
  tensors.set(0, 5, 0.5F, 0.49F, kBox, kPoints);  // just below the threshold of 0.5
  tensors.set(0, 6, 0.5F, 0.51F, kBox, kPoints);
  const auto found = decode_yunet(yunet_spec(), tensors.views());
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].detection.score, 1.0F);
  EXPECT_NEAR(found[1].detection.score, std::sqrt(0.255F), 1e-6F);
}

TEST(Yunet, OutputsOfAnotherNetworkAreAnError) {
  auto views = Tensors().views();
  std::swap(views[0], views[6]);
  const auto swapped = check_outputs(yunet_spec(), views);
  ASSERT_FALSE(swapped);
  EXPECT_NE(swapped.error().message.find("layout yunet"), std::string::npos) << swapped.error().message;
  views.pop_back();
  EXPECT_FALSE(check_outputs(yunet_spec(), views));
}

constexpr const char* kFile = "name: tiny\nfile: net.onnx\ninput: {width: 320, height: 320}\n";

Result<ModelSpec> described(const std::string& text) {
  const TemporaryFolder folder;
  folder.copy(std::string(EXTPERFC_TEST_DATA) + "/models/tiny_vector.onnx", "net.onnx");
  folder.write("model.yaml", text);
  return load_model_spec(folder.path());
}

void expect_problem(const Result<ModelSpec>& spec, const std::string& part) {
  ASSERT_FALSE(spec) << part;
  EXPECT_NE(spec.error().message.find(part), std::string::npos) << spec.error().message;
}

TEST(Yunet, DescriptionIsChecked) {
  const std::string names = "names: [a, b, c, d, e, f, g, h, i, j, k, l]}\n";
  EXPECT_TRUE(described(kFile + ("output: {layout: yunet, " + names) + "classes: [face]\n"));
  expect_problem(described(kFile + ("output: {layout: yunet, " + names) + "classes: [face, hat]\n"),
                 "one class");
  expect_problem(described(kFile + std::string("output: {layout: yunet, names: [a]}\nclasses: [face]\n")),
                 "has 12 output tensors, but 1");
  expect_problem(
      described("name: a\nfile: net.onnx\ninput: {width: 320, height: 240}\noutput: {layout: yunet, " +
                names + "classes: [face]\n"),
      "multiples of 32");
}

TEST(Vector, HasNoClassesAndNoBoxes) {
  const auto spec = described(kFile + std::string("output: {layout: vector}\n"));
  ASSERT_TRUE(spec) << spec.error().message;
  const auto detector = Detector::create(*spec, {});
  ASSERT_FALSE(detector);
  EXPECT_NE(detector.error().message.find("layout vector has no boxes"), std::string::npos);
  expect_problem(described(kFile + std::string("output: {layout: vector}\nclasses: [face]\n")),
                 "classes: is not used by layout vector");
}

}  // namespace
}  // namespace extperfc::detect

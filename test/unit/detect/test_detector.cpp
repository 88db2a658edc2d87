#include <algorithm>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "extperfc/detect/detector.hpp"

namespace extperfc::detect {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = EXTPERFC_SOURCE_DIR;
const fs::path kShared = kSource / "../shared/data";

ImageView view(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, image.step, PixelFormat::kBgr8};
}

/// The tiny SSD with a threshold so low that it finds something everywhere.
ModelSpec tiny_spec() {
  ModelSpec spec;
  spec.name = "tiny";
  spec.file = fs::path(EXTPERFC_TEST_DATA) / "models/tiny_ssd.onnx";
  spec.input.width = 32;
  spec.input.height = 24;
  spec.input.resize = Resize::kLetterbox;
  spec.input.scale = {1.0F / 255, 1.0F / 255, 1.0F / 255};
  spec.output.layout = OutputLayout::kSsd;
  spec.output.names = {"boxes", "scores"};
  spec.output.background_class = 0;
  spec.classes = {"cone", "cube", "sphere"};
  spec.thresholds.score = 0.01F;
  return spec;
}

TEST(Detector, BoxesLieInTheImageBestFirst) {
  auto detector = Detector::create(tiny_spec(), {});
  ASSERT_TRUE(detector) << detector.error().message;
  const cv::Mat image(200, 90, CV_8UC3, cv::Scalar(10, 200, 90));
  const auto output = detector->detect(view(image));
  ASSERT_TRUE(output) << output.error().message;
  ASSERT_FALSE(output->detections.empty());
  float last = 1;
  for (const auto& [class_index, score, box] : output->detections) {
    EXPECT_GE(class_index, 0);
    EXPECT_LT(class_index, 3);
    EXPECT_LE(score, last);
    last = score;
    EXPECT_GE(box.x_min, 0);
    EXPECT_GE(box.y_min, 0);
    EXPECT_LE(box.x_max, 90);
    EXPECT_LE(box.y_max, 200);
    EXPECT_GT(box.area(), 0);
  }
  EXPECT_GT(output->times.inference_ms, 0);
}

TEST(Detector, ASelectionReplacesTheModelsThresholds) {
  auto detector = Detector::create(tiny_spec(), {});
  ASSERT_TRUE(detector) << detector.error().message;
  const cv::Mat image(200, 90, CV_8UC3, cv::Scalar(10, 200, 90));
  const auto all = detector->detect(view(image));
  ASSERT_TRUE(all);
  ASSERT_GT(all->detections.size(), 1U);
  Selection selection{detector->spec().thresholds, {}};

  selection.thresholds.max_detections = 1;
  const auto best = detector->detect(view(image), selection);
  ASSERT_TRUE(best);
  ASSERT_EQ(best->detections.size(), 1U);
  EXPECT_EQ(best->detections[0].score, all->detections[0].score);

  selection.thresholds = detector->spec().thresholds;
  selection.classes = *ClassFilter::make("cube", detector->spec().classes);
  const auto cubes = detector->detect(view(image), selection);
  ASSERT_TRUE(cubes);
  const auto is_cube = [](const Detection& d) { return d.class_index == 1; };
  EXPECT_EQ(static_cast<std::ptrdiff_t>(cubes->detections.size()),
            std::count_if(all->detections.begin(), all->detections.end(), is_cube));
  EXPECT_TRUE(std::all_of(cubes->detections.begin(), cubes->detections.end(), is_cube));

  selection.classes = {};
  selection.thresholds.score = 1.0F;
  const auto none = detector->detect(view(image), selection);
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->detections.empty());
  const auto again = detector->detect(view(image));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->detections.size(), all->detections.size()) << "a selection is of one call";
}

TEST(Detector, BadImagesAndSlotsAreErrors) {
  auto detector = Detector::create(tiny_spec(), {});
  ASSERT_TRUE(detector) << detector.error().message;
  EXPECT_EQ(detector->detect({}).error().code, ErrorCode::kInvalidArgument);
  const cv::Mat image = cv::Mat::zeros(8, 8, CV_8UC3);
  EXPECT_EQ(detector->detect(view(image), detector->slots()).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(detector->detect(view(image), -1).error().code, ErrorCode::kInvalidArgument);
  EXPECT_TRUE(detector->detect(view(image)));
}

TEST(Detector, MissingNetworkIsAnError) {
  ModelSpec spec = tiny_spec();
  spec.file = "/no/such.onnx";
  const auto detector = Detector::create(spec, {});
  ASSERT_FALSE(detector);
  EXPECT_NE(detector.error().message.find("/no/such.onnx"), std::string::npos) << detector.error().message;
}

/// The public network FastestDet on images of a dining room (NYU Depth).
class FastestDet : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!fs::exists(kShared / "models/fastestdet")) GTEST_SKIP() << "no shared data beside the sources";
  }

  static Result<Detector> create(const std::string& backend) {
    auto spec = load_model_spec(kShared / "models/fastestdet", kSource / "config/models");
    if (!spec) return tl::unexpected(spec.error());
    InferenceOptions options;
    options.backend = backend;
    return Detector::create(std::move(*spec), options);
  }
};

INSTANTIATE_TEST_SUITE_P(All, FastestDet, testing::ValuesIn(available_backends()),
                         [](const auto& instance) { return instance.param; });

TEST_P(FastestDet, FindsTheChairsWhereTheyAre) {
  auto detector = create(GetParam());
  ASSERT_TRUE(detector) << detector.error().message;
  // Outlined by hand: the armchair and the chair beside the cabinet, the armchair from nearer by.
  const std::vector<std::pair<std::string, Box2>> chairs{
      {"1.png", {120, 138, 222, 285}}, {"1.png", {490, 176, 602, 275}}, {"4.png", {285, 130, 435, 340}}};
  for (const auto& [file, truth] : chairs) {
    const cv::Mat image = cv::imread((kShared / "rgbd/dining_room/rgb" / file).string());
    ASSERT_FALSE(image.empty());
    const auto found = detector->detect(view(image)).value().detections;
    const bool hit = std::any_of(found.begin(), found.end(), [&, &box = truth](const Detection& detection) {
      return detector->spec().classes[static_cast<std::size_t>(detection.class_index)] == "chair" &&
             iou(detection.box, box) > 0.7F;
    });
    EXPECT_TRUE(hit) << file << " at " << truth.x_min << ' ' << truth.y_min;
  }
}

TEST_P(FastestDet, FindsNothingOnGrey) {
  auto detector = create(GetParam());
  ASSERT_TRUE(detector) << detector.error().message;
  EXPECT_TRUE(
      detector->detect(view(cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(114)))).value().detections.empty());
}

}  // namespace
}  // namespace extperfc::detect

// The published YuNet on photographs of installed packages. Skipped where one of both is missing.
#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "extperfc/detect/detector.hpp"
#include "extperfc/face/recognizer.hpp"

#include "test/support/photographs.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::face {
namespace {

namespace fs = std::filesystem;

ImageView view(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, image.step, PixelFormat::kBgr8};
}

detect::InferenceOptions with(const std::string& backend) {
  detect::InferenceOptions options;
  options.backend = backend;
  options.threads = 1;
  return options;
}

class PhotographTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = yunet_folder(EXTPERFC_SOURCE_DIR);
    if (!folder) GTEST_SKIP() << "no YuNet in shared/data/models/yunet";
    for (const char* size : {"320", "640"}) {
      fs::create_directory(models_.path() / size);
      models_.copy(*folder / (std::string("yunet_n_") + size + "_" + size + ".onnx"),
                   std::string(size) + "/a.onnx");
    }
    photographs_ = installed_photographs();
    if (photographs_.empty()) GTEST_SKIP() << "no photograph: install python3-matplotlib";
  }

  [[nodiscard]] detect::ModelSpec spec(const std::string& size = "320") const {
    const auto spec =
        detect::load_model_spec(models_.path() / size, fs::path(EXTPERFC_SOURCE_DIR) / "config/models");
    EXPECT_TRUE(spec) << spec.error().message;
    return spec.value();
  }

  [[nodiscard]] FaceDetector detector(const std::string& size = "320",
                                      const std::string& backend = "opencv") const {
    auto detector = FaceDetector::create(spec(size), with(backend));
    EXPECT_TRUE(detector) << detector.error().message;
    return std::move(detector.value());
  }

  /// Feature of the one face in an image.
  Feature feature_of(FaceEmbedder& embedder, const cv::Mat& image) {
    const auto faces = detector_of_features().detect(view(image));
    EXPECT_TRUE(faces && faces->size() == 1U);
    const auto aligned = align(view(image), {faces.value().at(0).landmarks});
    return embedder.embed(aligned.value()[0].value()).value();
  }

  FaceDetector& detector_of_features() {
    if (!detector_) detector_.emplace(detector());
    return *detector_;
  }

  TemporaryFolder models_;
  std::vector<Photograph> photographs_;
  std::optional<FaceDetector> detector_;
};

void expect_face(const std::vector<DetectedFace>& faces, const Photograph& photograph, float shift_x = 0) {
  ASSERT_EQ(faces.size(), 1U) << photograph.file;
  const auto& [box, landmarks, score] = faces.front();
  EXPECT_GT(score, 0.8F);
  const Eigen::Vector2f eyes = 0.5F * (landmarks[0] + landmarks[1]);
  const float tolerance = 0.15F * photograph.eye_distance;
  EXPECT_NEAR(eyes.x(), photograph.eye_x + shift_x, tolerance);
  EXPECT_NEAR(eyes.y(), photograph.eye_y, tolerance);
  EXPECT_NEAR(landmarks[1].x() - landmarks[0].x(), photograph.eye_distance, tolerance);
  EXPECT_GT(landmarks[2].y(), eyes.y()) << "the nose below the eyes";
  EXPECT_GT(landmarks[3].y(), landmarks[2].y()) << "the mouth below the nose";
  EXPECT_LT(landmarks[3].x(), landmarks[4].x());
  for (const auto& point : landmarks) {
    EXPECT_GT(point.x(), box.x_min);
    EXPECT_LT(point.x(), box.x_max);
  }
}

TEST_F(PhotographTest, TheFaceIsWhereItIs) {
  for (const char* size : {"320", "640"}) {
    auto finder = detector(size);
    for (const auto& photograph : photographs_) {
      const auto faces = finder.detect(view(cv::imread(photograph.file.string())));
      ASSERT_TRUE(faces) << faces.error().message;
      expect_face(*faces, photograph);
    }
  }
}

TEST_F(PhotographTest, BordersAroundTheImageMoveTheFaceOnly) {
  constexpr int kLeft = 300;
  auto finder = detector();
  const auto& photograph = photographs_.front();
  cv::Mat wide;
  cv::copyMakeBorder(cv::imread(photograph.file.string()), wide, 0, 0, kLeft, 20, cv::BORDER_CONSTANT);
  const auto faces = finder.detect(view(wide));
  ASSERT_TRUE(faces) << faces.error().message;
  expect_face(*faces, photograph, kLeft);
}

TEST_F(PhotographTest, ImagesWithoutFacesHaveNone) {
  auto finder = detector();
  cv::Mat noise(240, 320, CV_8UC3);
  cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 255);
  for (const cv::Mat& image : {cv::Mat(240, 320, CV_8UC3, cv::Scalar(90, 120, 30)), noise}) {
    const auto faces = finder.detect(view(image));
    ASSERT_TRUE(faces);
    EXPECT_TRUE(faces->empty());
  }
  EXPECT_EQ(finder.detect({}).error().code, ErrorCode::kInvalidArgument);
}

TEST_F(PhotographTest, BackEndsAgree) {
  const auto backends = detect::available_backends();
  if (std::find(backends.begin(), backends.end(), "openvino") == backends.end())
    GTEST_SKIP() << "this build has no OpenVINO";
  auto opencv = detector();
  auto openvino = detector("320", "openvino");
  for (const auto& photograph : photographs_) {
    const cv::Mat image = cv::imread(photograph.file.string());
    const auto a = opencv.detect(view(image));
    const auto b = openvino.detect(view(image));
    ASSERT_TRUE(a && b);
    ASSERT_EQ(a->size(), 1U);
    ASSERT_EQ(b->size(), 1U);
    EXPECT_NEAR(a->front().score, b->front().score, 1e-3F);
    EXPECT_GT(iou(a->front().box, b->front().box), 0.995F);
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_LT((a->front().landmarks[i] - b->front().landmarks[i]).norm(), 0.5F) << i;
  }
}

TEST_F(PhotographTest, ADetectorOfObjectsFindsTheFaceToo) {
  auto objects = detect::Detector::create(spec(), with("opencv"));
  ASSERT_TRUE(objects) << objects.error().message;
  const auto found = objects->detect(view(cv::imread(photographs_.front().file.string())));
  ASSERT_TRUE(found);
  ASSERT_EQ(found->detections.size(), 1U);
  EXPECT_TRUE(found->detections[0].box.x_min < photographs_.front().eye_x &&
              photographs_.front().eye_x < found->detections[0].box.x_max);
}

TEST_F(PhotographTest, SmallFacesGetNoFeature) {
  const cv::Mat image = cv::imread(photographs_.front().file.string());
  for (const auto& [min_face_px, wanted] : {std::pair{50.0F, true}, {2000.0F, false}}) {
    Recognizer recognizer(detector(), make_lbp_embedder(), min_face_px);
    const auto faces = recognizer.describe(view(image));
    ASSERT_TRUE(faces) << faces.error().message;
    ASSERT_EQ(faces->size(), 1U);
    EXPECT_EQ(faces->front().feature.has_value(), wanted) << min_face_px;
  }
}

TEST_F(PhotographTest, LocalBinaryPatternsSeeTheSameFaceUnderOtherLight) {
  const auto embedder = make_lbp_embedder();
  const cv::Mat image = cv::imread(photographs_.front().file.string());
  const Feature known = feature_of(*embedder, image);
  cv::Mat dark;
  image.convertTo(dark, CV_8U, 0.5);
  cv::Mat pale;
  image.convertTo(pale, CV_8U, 0.6, 90);
  cv::Mat smaller;
  cv::resize(image, smaller, {}, 0.8, 0.8, cv::INTER_AREA);
  for (const cv::Mat& same : {dark, pale, smaller})
    EXPECT_GT(similarity(known, feature_of(*embedder, same)), embedder->default_threshold());
}

TEST_F(PhotographTest, LocalBinaryPatternsOfTwoPeopleDiffer) {
  if (photographs_.size() < 2) GTEST_SKIP() << "no second person: install python3-skimage";
  const auto embedder = make_lbp_embedder();
  const Feature known = feature_of(*embedder, cv::imread(photographs_[0].file.string()));
  const Feature other = feature_of(*embedder, cv::imread(photographs_[1].file.string()));
  EXPECT_LT(similarity(known, other), embedder->default_threshold());
}

}  // namespace
}  // namespace extperfc::face

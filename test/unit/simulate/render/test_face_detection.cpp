// A detector of real faces finds those of simulated people: YuNet (Wu, Peng and Yu 2023), whose network lies
// beside the sources.

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "test/unit/simulate/render/face_camera.hpp"

namespace extperfc::simulate {
namespace {

const std::filesystem::path kNetwork =
    std::filesystem::path(EXTPERFC_SOURCE_DIR) / "../shared/data/models/yunet/yunet_n_640_640.onnx";

struct DetectedFace {
  float score{0};
  std::array<Eigen::Vector2d, 5> landmarks;  ///< [px]
};

class FaceDetection : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kNetwork)) GTEST_SKIP() << "no " << kNetwork << " beside the sources";
    network_ = cv::dnn::readNet(kNetwork.string());
  }

  /// The face with the highest score of an image of 640 x 480.
  DetectedFace detect(const CameraImages& images) {
    cv::Mat rgb(images.height, images.width, CV_8UC3, const_cast<std::uint8_t*>(images.rgb.data()));
    cv::Mat square;
    cv::copyMakeBorder(rgb, square, 0, kSide - images.height, 0, kSide - images.width, cv::BORDER_CONSTANT);
    cv::cvtColor(square, square, cv::COLOR_RGB2BGR);
    network_.setInput(cv::dnn::blobFromImage(square));
    DetectedFace best;
    for (const int stride : {8, 16, 32}) decode(stride, best);
    return best;
  }

 private:
  static constexpr int kSide = 640;

  void decode(int stride, DetectedFace& best) {
    std::vector<cv::Mat> outputs;
    const std::string level = "_" + std::to_string(stride);
    network_.forward(outputs, std::vector<cv::String>{"cls" + level, "obj" + level, "kps" + level});
    const int columns = kSide / stride;
    const auto* points = outputs[2].ptr<float>();
    for (int i = 0; i < columns * columns; ++i, points += 10) {
      const float score = std::sqrt(outputs[0].ptr<float>()[i] * outputs[1].ptr<float>()[i]);
      if (score <= best.score) continue;
      best.score = score;
      const Eigen::Vector2d cell(i % columns, i / columns);
      for (std::size_t k = 0; k < best.landmarks.size(); ++k)
        best.landmarks[k] =
            (cell + Eigen::Vector2f(points[2 * k], points[2 * k + 1]).cast<double>()) * stride;
    }
  }

  cv::dnn::Net network_;
};

TEST_F(FaceDetection, FindsFacesAndTheirLandmarks) {
  for (int seed = 0; seed < 6; ++seed) {
    FaceCamera camera(seed);
    for (const double distance_m : {1.0, 3.0})
      for (const double yaw : {-0.5, 0.0}) {
        SCOPED_TRACE("seed " + std::to_string(seed) + " at " + std::to_string(distance_m) + " m, yaw " +
                     std::to_string(yaw));
        const DetectedFace found = detect(camera.look(distance_m, yaw));
        ASSERT_GT(found.score, 0.6F);
        const auto truth = camera.landmarks();
        const double eyes_px = 465.6 * 0.063 / distance_m;
        double sum = 0;
        for (std::size_t i = 0; i < truth.size(); ++i)
          sum += (found.landmarks[i] - camera.project(truth[i])).norm();
        EXPECT_LT(sum / 5, 0.35 * eyes_px);
      }
  }
}

TEST_F(FaceDetection, FindsNoFaceOnTheBackOfAHead) {
  for (int seed = 0; seed < 3; ++seed) {
    FaceCamera camera(seed);
    EXPECT_LT(detect(camera.look(1.0, M_PI)).score, 0.6F) << "seed " << seed;
  }
}

}  // namespace
}  // namespace extperfc::simulate

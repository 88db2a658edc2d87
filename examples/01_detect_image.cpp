// Detects objects in an image file:  01_detect_image IMAGE [MODEL_FOLDER]
#include <opencv2/imgcodecs.hpp>

#include "extperfc/detect/detector.hpp"

#include "examples/example.hpp"

using namespace extperfc;

int main(int argc, char** argv) {
  if (argc < 2) return std::cerr << "usage: 01_detect_image IMAGE [MODEL_FOLDER]\n", 2;
  const cv::Mat pixels = cv::imread(argv[1]);
  if (pixels.empty()) return std::cerr << argv[1] << " is not an image that can be read\n", 1;

  // A model is a folder with an ONNX file and a model.yaml that describes it.
  const auto spec =
      examples::value_of(detect::load_model_spec(argc > 2 ? argv[2] : EXTPERFC_MODELS "/shapes"));
  detect::InferenceOptions options;  // back end, device and threads; by default the fastest back end
  auto detector = examples::value_of(detect::Detector::create(spec, options));

  // A view copies no pixels: images of a camera driver are used in place.
  const ImageView image{pixels.data, pixels.cols, pixels.rows, pixels.step, PixelFormat::kBgr8};
  const auto output = examples::value_of(detector.detect(image));

  std::cout << detector.execution() << ", " << output.times.inference_ms << " ms\n";
  for (const Detection& found : output.detections)
    std::cout << spec.classes[static_cast<std::size_t>(found.class_index)] << " " << found.score << " at x "
              << found.box.x_min << " to " << found.box.x_max << ", y " << found.box.y_min << " to "
              << found.box.y_max << "\n";
}

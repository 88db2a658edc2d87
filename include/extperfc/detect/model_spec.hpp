#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "extperfc/base/error.hpp"

namespace extperfc::detect {

/// How the network's output tensors are laid out. Shapes are without the leading batch dimension of 1.
enum class OutputLayout {
  kSsd,        ///< boxes [N, 4] + scores [N, C]; boxes are corners x0 y0 x1 y1 relative to the input (0 to 1)
  kSsdPriors,  ///< offsets [N, 4] + class logits or scores [N, C], decoded against prior boxes (Liu et al.
               ///< 2016, sec. 2.2)
  kYoloV7,  ///< [N, 5 + C] cx cy w h objectness class..., input pixels, sigmoid already applied (Wang et al.
            ///< 2022)
  kYoloV8,  ///< [4 + C, N] cx cy w h class..., input pixels, no objectness, sigmoid already applied
  kYoloAnchors,  ///< one raw head per level [A * (5 + C), H, W]; YOLOv5/v7 anchor decoding
  kYoloGrid,     ///< one raw anchor-free head [1 + 4 + C, H, W]: objectness, tx ty tw th, class scores
                 ///< (FastestDet)
  kYunet,        ///< cls, obj, bbox, kps of strides 8, 16, 32: see yunet.hpp
  kVector,       ///< [N]: numbers that describe the whole image, no boxes; not for a Detector
};

/// Layout of a model.yaml name (`ssd`, `ssd_priors`, `yolo_v7`, `yolo_v8`, `yolo_anchors`, `yolo_grid`,
/// `yunet`, `vector`).
[[nodiscard]] Result<OutputLayout> layout_from_name(const std::string& name);
[[nodiscard]] const char* to_string(OutputLayout layout);

enum class Resize {
  kStretch,    ///< each axis scaled on its own
  kLetterbox,  ///< aspect kept, centred, the rest filled with grey 114
};

enum class Interpolation { kLinear, kArea };

/// The network's input: [1, 3, height, width], float32.
struct InputSpec {
  std::string name;  ///< tensor name; empty = the network's only input
  int width{0};      ///< pixels
  int height{0};     ///< pixels
  bool bgr{false};   ///< channel order that the network was trained on
  Resize resize{Resize::kStretch};
  Interpolation interpolation{Interpolation::kLinear};
  std::array<float, 3> mean{};          ///< 8-bit units, in the network's channel order
  std::array<float, 3> scale{1, 1, 1};  ///< x' = (x - mean) * scale
};

/// One prior (default) box: centre and size relative to the input.
struct Prior {
  float cx, cy, w, h;
};

/// Anchors of one level of a YOLO head.
struct AnchorLevel {
  int stride{0};                               ///< input pixels per cell
  std::vector<std::array<float, 2>> sizes_px;  ///< width, height in input pixels
};

struct OutputSpec {
  OutputLayout layout{OutputLayout::kYoloV8};
  std::vector<std::string> names;  ///< tensors in the order that the layout lists, bound by name; empty = the
                                   ///< network's only output
  int background_class{-1};        ///< SSD: index of the background in the score tensor, -1 = none
  bool apply_softmax{false};       ///< SSD: scores are logits
  std::array<float, 2> variances{0.1F, 0.2F};  ///< SSD priors: centre and size variance
  std::vector<Prior> priors;                   ///< SSD priors
  std::vector<AnchorLevel> anchors;            ///< YOLO anchors, one entry per output
};

struct Thresholds {
  float score{0.5F};     ///< keep at or above, [0, 1]
  float nms_iou{0.45F};  ///< suppress above, [0, 1], per class
  int max_detections{100};
};

/// Everything that model.yaml says. See models/README.md for the format.
struct ModelSpec {
  std::string name;
  std::filesystem::path folder;
  std::filesystem::path file;  ///< the ONNX file, absolute
  std::string sha256;
  InputSpec input;
  OutputSpec output;
  std::vector<std::string> classes;  ///< without the background
  Thresholds thresholds;
  std::string source;
  std::string license;
};

/// Reads and checks a model folder: model.yaml well formed (every problem reported at once, with key and
/// remedy, unknown keys too), the ONNX file there, its SHA-256 as stated. A folder without model.yaml whose
/// one ONNX file is a known public network (by SHA-256, descriptions in `known_models`) is read with that
/// description. Errors: kNotFound, kCorrupt (wrong SHA-256 or not YAML), kInvalidArgument (values),
/// kUnsupported (layout).
[[nodiscard]] Result<ModelSpec> load_model_spec(const std::filesystem::path& folder,
                                                const std::filesystem::path& known_models = {});

}  // namespace extperfc::detect

#include "extperfc/detect/decode.hpp"

#include <string>

#include "detect/decode_layouts.hpp"

namespace extperfc::detect {

namespace {

constexpr int kAny = -1;

std::string shape_text(const std::vector<int>& shape) {
  std::string text;
  for (const int n : shape) text += (text.empty() ? "" : ", ") + (n == kAny ? "N" : std::to_string(n));
  return "[" + text + "]";
}

/// With or without the leading batch dimension of 1.
bool matches(std::vector<int> shape, const std::vector<int>& expected) {
  if (shape.size() == expected.size() + 1 && shape.front() == 1) shape.erase(shape.begin());
  if (shape.size() != expected.size()) return false;
  for (std::size_t i = 0; i < shape.size(); ++i)
    if (shape[i] <= 0 || (expected[i] != kAny && shape[i] != expected[i])) return false;
  return true;
}

int cells_along(int pixels, int stride) {
  return (pixels + stride - 1) / stride;
}

/// What the layout asks of every tensor.
std::vector<std::vector<int>> expected_shapes(const ModelSpec& spec) {
  const int classes = static_cast<int>(spec.classes.size());
  std::vector<std::vector<int>> shapes;
  switch (spec.output.layout) {
    case OutputLayout::kSsd:
      return {{kAny, 4}, {kAny, ssd_columns(spec)}};
    case OutputLayout::kSsdPriors: {
      const int priors = static_cast<int>(spec.output.priors.size());
      return {{priors, 4}, {priors, ssd_columns(spec)}};
    }
    case OutputLayout::kYoloV7:
      return {{kAny, 5 + classes}};
    case OutputLayout::kYoloV8:
      return {{4 + classes, kAny}};
    case OutputLayout::kYoloAnchors:
      for (const AnchorLevel& level : spec.output.anchors)
        shapes.push_back({static_cast<int>(level.sizes_px.size()) * (5 + classes),
                          cells_along(spec.input.height, level.stride),
                          cells_along(spec.input.width, level.stride)});
      return shapes;
    case OutputLayout::kYoloGrid:
      return {{5 + classes, kAny, kAny}};
    case OutputLayout::kYunet:
      return yunet_shapes(spec.input);
    case OutputLayout::kVector:
      return {{kAny}};
  }
  return shapes;
}

tl::unexpected<Error> wrong_shape(const ModelSpec& spec, std::size_t index, const std::vector<int>& shape,
                                  const std::vector<int>& expected) {
  const std::string name =
      index < spec.output.names.size() ? spec.output.names[index] : std::to_string(index);
  return fail(ErrorCode::kInvalidArgument,
              spec.name + ": output \"" + name + "\" has shape " + shape_text(shape) + ", but layout " +
                  to_string(spec.output.layout) + " with " + std::to_string(spec.classes.size()) +
                  " classes needs " + shape_text(expected) +
                  " (the batch of 1 apart): correct output.layout, output.names or classes in model.yaml");
}

}  // namespace

Result<void> check_outputs(const ModelSpec& spec, const std::vector<TensorView>& outputs) {
  const auto expected = expected_shapes(spec);
  if (outputs.size() != expected.size())
    return fail(ErrorCode::kInvalidArgument,
                spec.name + ": layout " + to_string(spec.output.layout) + " has " +
                    std::to_string(expected.size()) + " output tensors, but the network delivers " +
                    std::to_string(outputs.size()) + ": correct output.names in model.yaml");
  for (std::size_t i = 0; i < outputs.size(); ++i)
    if (!matches(outputs[i].shape, expected[i])) return wrong_shape(spec, i, outputs[i].shape, expected[i]);

  if (spec.output.layout == OutputLayout::kSsd &&
      axis_from_end(outputs[0], 1) != axis_from_end(outputs[1], 1))
    return wrong_shape(spec, 1, outputs[1].shape, {axis_from_end(outputs[0], 1), ssd_columns(spec)});
  return {};
}

Detections decode(const ModelSpec& spec, const std::vector<TensorView>& outputs) {
  switch (spec.output.layout) {
    case OutputLayout::kSsd:
      return decode_ssd(spec, outputs);
    case OutputLayout::kSsdPriors:
      return decode_ssd_priors(spec, outputs);
    case OutputLayout::kYoloV7:
      return decode_yolo_v7(spec, outputs[0]);
    case OutputLayout::kYoloV8:
      return decode_yolo_v8(spec, outputs[0]);
    case OutputLayout::kYoloAnchors:
      return decode_yolo_anchors(spec, outputs);
    case OutputLayout::kYoloGrid:
      return decode_yolo_grid(spec, outputs[0]);
    case OutputLayout::kYunet:
      return decode_yunet_boxes(spec, outputs);
    case OutputLayout::kVector:
      break;
  }
  return {};
}

}  // namespace extperfc::detect

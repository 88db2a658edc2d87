#include "extperfc/detect/detector.hpp"

#include <algorithm>
#include <utility>

#include "extperfc/base/stopwatch.hpp"
#include "extperfc/detect/decode.hpp"

namespace extperfc::detect {

namespace {

/// Boxes in the image's pixels, clipped to it; those that lie outside are left out.
Detections place(const Detections& found, const Placement& placement, int width, int height) {
  const auto w = static_cast<float>(width);
  const auto h = static_cast<float>(height);
  Detections placed;
  for (const Detection& detection : found) {
    const Box2 box = placement.to_image(detection.box);
    const Box2 clipped{std::max(box.x_min, 0.0F), std::max(box.y_min, 0.0F), std::min(box.x_max, w),
                       std::min(box.y_max, h)};
    if (clipped.width() > 0.0F && clipped.height() > 0.0F)
      placed.push_back({detection.class_index, detection.score, clipped});
  }
  return placed;
}

Detections of_classes(Detections candidates, const ClassFilter& classes) {
  if (classes.allows_all()) return candidates;
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                  [&](const Detection& d) { return !classes.allows(d.class_index); }),
                   candidates.end());
  return candidates;
}

}  // namespace

Detector::Detector(ModelSpec spec, std::unique_ptr<InferenceBackend> backend)
    : spec_(std::move(spec)), backend_(std::move(backend)) {
  for (int slot = 0; slot < backend_->slots(); ++slot) preprocessors_.emplace_back(spec_.input);
  selected_.assign(preprocessors_.size(), spec_);
}

Result<Detector> Detector::create(ModelSpec spec, const InferenceOptions& options) {
  if (spec.output.layout == OutputLayout::kVector)
    return fail(ErrorCode::kUnsupported,
                spec.name + ": layout vector has no boxes: use a model that detects");
  auto backend = make_backend(spec, options);
  if (!backend) return tl::unexpected(backend.error());
  return Detector(std::move(spec), std::move(*backend));
}

Result<DetectorOutput> Detector::detect(const ImageView& image, int slot) {
  return detect(image, {spec_.thresholds, {}}, slot);
}

Result<DetectorOutput> Detector::detect(const ImageView& image, const Selection& selection, int slot) {
  if (slot < 0 || slot >= slots())
    return fail(ErrorCode::kInvalidArgument,
                "there is no slot " + std::to_string(slot) + ": the back end has " + std::to_string(slots()));
  DetectorOutput output;
  Stopwatch watch;
  const auto placement = preprocessors_[static_cast<std::size_t>(slot)].run(image, backend_->input(slot));
  if (!placement) return tl::unexpected(placement.error());
  output.times.preprocess_ms = watch.milliseconds();

  watch.restart();
  const auto tensors = backend_->infer(slot);
  if (!tensors) return tl::unexpected(tensors.error());
  output.times.inference_ms = watch.milliseconds();

  watch.restart();
  auto& selected = selected_[static_cast<std::size_t>(slot)];
  selected.thresholds = selection.thresholds;
  const Detections found =
      suppress(of_classes(decode(selected, *tensors), selection.classes), selection.thresholds);
  output.detections = place(found, *placement, image.width, image.height);
  output.times.decode_ms = watch.milliseconds();
  return output;
}

}  // namespace extperfc::detect

#pragma once

#include <memory>

#include "extperfc/base/error.hpp"
#include "extperfc/detect/model_spec.hpp"
#include "extperfc/world/detection.hpp"
#include "extperfc/world/image_view.hpp"

namespace extperfc::detect {

/// Where the image lies in the network's input: x_input = x_image * scale_x + offset_x, likewise y.
struct Placement {
  float scale_x{1};
  float scale_y{1};
  float offset_x{0};
  float offset_y{0};

  /// A box in input pixels as a box in image pixels.
  [[nodiscard]] Box2 to_image(const Box2& input_box) const;
};

/// Writes `image` resized, in the network's channel order, as (x - mean) * scale into `planes` ([3, height,
/// width] of `spec`). Colour conversion happens on the small image. Any colour format of PixelFormat.
/// Errors: kInvalidArgument for an empty image, kUnsupported for a depth image.
class Preprocessor {
 public:
  explicit Preprocessor(InputSpec spec);
  ~Preprocessor();
  Preprocessor(Preprocessor&&) noexcept;
  Preprocessor& operator=(Preprocessor&&) noexcept;

  /// Not safe for several threads on one Preprocessor: it keeps scratch memory.
  [[nodiscard]] Result<Placement> run(const ImageView& image, float* planes);

 private:
  struct Scratch;
  InputSpec spec_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace extperfc::detect

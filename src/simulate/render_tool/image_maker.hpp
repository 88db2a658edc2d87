#pragma once

#include <memory>
#include <string>
#include <vector>

#include "extperfc/base/rng.hpp"
#include "extperfc/simulate/sensor_rig.hpp"

#include "simulate/render_tool/options.hpp"

namespace extperfc::simulate {

struct Annotation {
  std::string label;
  VisibleBox box;
  double visible{1};  ///< fraction of the whole object that is seen
  bool truncated{false};
  bool occluded{false};
  bool difficult{false};
};

struct AnnotatedImage {
  int jpeg_quality{93};  ///< 1 to 100
  CameraImages images;
  std::vector<Annotation> annotations;
};

/// Makes images by their number; keeps the world of the last one, so take neighbours in a row. Each thread
/// has its own.
class ImageMaker {
 public:
  /// Images of one random world; neighbours in number.
  static constexpr int kImagesPerWorld = 4;

  /// `fixed_world`: all images are taken of this one; null: of random ones.
  ImageMaker(const Options& options, std::shared_ptr<const WorldSpec> fixed_world);

  /// Image `number`, from 0. The result stays until the next call. Depends on the options and the number
  /// only. Errors: of SensorRig.
  [[nodiscard]] Result<const AnnotatedImage*> make(int number);

  /// The world that an image is taken of, for splitting into training and validation.
  [[nodiscard]] static std::uint64_t world_of(const Options& options, int number);

 private:
  [[nodiscard]] Result<void> enter_world(int number);
  [[nodiscard]] bool varied(std::int64_t world_index) const;
  [[nodiscard]] Pose choose_view(Rng& rng, const CameraParams& params);
  [[nodiscard]] int count_visible() const;  ///< objects of the classes and people, in the preview
  [[nodiscard]] bool asked_for(const std::string& label) const;
  void annotate(const CameraParams& params, const Pose& world_T_optical);

  Options options_;
  std::shared_ptr<const WorldSpec> world_;
  bool fixed_{false};
  std::int64_t world_index_{-1};
  std::unique_ptr<SensorRig> rig_;
  std::vector<Eigen::Vector3d> targets_;
  CameraImages preview_;
  AnnotatedImage image_;
};

/// A number that differs for every pair, for seeds (SplitMix64).
[[nodiscard]] std::uint64_t mix(std::uint64_t seed, std::uint64_t number);

}  // namespace extperfc::simulate

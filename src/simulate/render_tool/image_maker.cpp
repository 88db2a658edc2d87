#include "simulate/render_tool/image_maker.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "extperfc/base/math.hpp"
#include "extperfc/simulate/random_world.hpp"

#include "simulate/render_tool/camera_effects.hpp"
#include "simulate/render_tool/random_view.hpp"
#include "simulate/render_tool/whole_view.hpp"
#include "simulate/worlds/varied_world.hpp"

namespace extperfc::simulate {

namespace {

constexpr int kMaxViews = 25;  // views that are looked at before the last one is taken
constexpr int kJpegQuality = 93;
constexpr int kPreviewRows = 60;
constexpr float kNear_m = 0.25F;      // nothing that is nearer may fill much of an ordinary image
constexpr float kVeryNear_m = 0.13F;  // of a varied one
constexpr double kElsewhere = 0.04;   // fraction of the images that look anywhere in the room
constexpr double kOccluded = 0.95;
constexpr double kDifficultFraction = 0.3;
constexpr int kDifficultSize = 12;  // [px]

RandomWorldParams world_params(Rng& rng) {
  RandomWorldParams params;
  params.min_objects = 3;
  params.max_objects = rng.chance(0.3) ? 18 : 10;
  params.max_distractors = rng.chance(0.3) ? 14 : 7;
  params.crowded = rng.uniform(0.2, 0.9);
  return params;
}

/// A point of each person's path, in any direction.
std::vector<Pose2> random_people(Rng& rng, const WorldSpec& world) {
  std::vector<Pose2> poses;
  for (const PersonSpec& person : world.people) {
    const auto& path = person.path_m;
    const auto at = static_cast<std::size_t>(rng.integer(0, static_cast<int>(path.size()) - 1));
    const Eigen::Vector2d point = path[at] + rng.uniform(0, 1) * (path[(at + 1) % path.size()] - path[at]);
    poses.push_back({point.x(), point.y(), rng.uniform(-kPi, kPi)});
  }
  return poses;
}

Snapshot snapshot_of(const WorldSpec& world, std::vector<Pose2> people, double time_s) {
  Snapshot snapshot;
  snapshot.time_s = time_s;
  for (const BodySpec& body : world.bodies) snapshot.world_T_body.push_back(body.world_T_body);
  snapshot.world_T_person = std::move(people);
  return snapshot;
}

/// Fraction of the pixels that are nearer than `limit_m` or show nothing at all.
double bad_fraction(const CameraImages& images, float limit_m) {
  std::size_t bad = 0;
  for (const float depth : images.true_depth_m) bad += depth < limit_m ? 1U : 0U;
  return static_cast<double>(bad) / static_cast<double>(std::max<std::size_t>(1, images.true_depth_m.size()));
}

/// The same view with a fraction of the pixels, to look whether it is worth an image.
CameraParams preview_of(const CameraParams& params) {
  CameraParams preview = params;
  const double scale = static_cast<double>(kPreviewRows) / params.model.height;
  preview.model.width = static_cast<int>(params.model.width * scale);
  preview.model.height = kPreviewRows;
  for (double* value : {&preview.model.fx, &preview.model.fy, &preview.model.cx, &preview.model.cy})
    *value *= scale;
  preview.shadows = false;
  preview.supersampling = 1;
  return preview;
}

Eigen::Vector3d random_place(Rng& rng, const WorldSpec& world) {
  const Eigen::Vector2d middle = (world.min_m + world.max_m) / 2;
  return Eigen::Vector3d{middle.x() + rng.uniform(-1, 1), middle.y() + rng.uniform(-1, 1), rng.uniform(0, 1)};
}

/// Whether a cone shows nothing but its base: the camera stands within the cone's mirror image below it.
bool shows_base_only(const BodySpec& body, const Pose& world_T_optical) {
  const auto* cone = body.shapes.empty() ? nullptr : std::get_if<Cone>(&body.shapes[0].geometry);
  if (cone == nullptr) return false;
  const Pose world_T_shape = body.world_T_body * body.shapes[0].body_T_shape;
  const Eigen::Vector3d eye = world_T_shape.inverse() * world_T_optical.translation();
  const double below_tip = cone->height_m / 2 - eye.z();
  return eye.z() < -cone->height_m / 2 && eye.head<2>().norm() < below_tip * cone->radius_m / cone->height_m;
}

}  // namespace

std::uint64_t mix(std::uint64_t seed, std::uint64_t number) {
  std::uint64_t z = seed * 0x9E3779B97F4A7C15U + number + 0x632BE59BD9B4E019U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

ImageMaker::ImageMaker(const Options& options, std::shared_ptr<const WorldSpec> fixed_world)
    : options_(options), world_(std::move(fixed_world)), fixed_(world_ != nullptr) {}

std::uint64_t ImageMaker::world_of(const Options& options, int number) {
  return mix(options.seed,
             static_cast<std::uint64_t>(options.world.empty() ? number / kImagesPerWorld : number));
}

bool ImageMaker::varied(std::int64_t world_index) const {
  if (fixed_ || options_.scenes == Scenes::kOrdinary) return false;
  return options_.scenes == Scenes::kVaried || world_index % 2 == 1;
}

Result<void> ImageMaker::enter_world(int number) {
  const std::int64_t index = fixed_ ? 0 : number / kImagesPerWorld;
  if (index == world_index_) return {};
  const std::uint64_t seed = mix(options_.seed, static_cast<std::uint64_t>(index));
  if (varied(index)) {
    world_ = std::make_shared<const WorldSpec>(varied_world(seed));
  } else if (!fixed_) {
    Rng rng(mix(seed, 1));
    auto world = random_world(world_params(rng), seed);
    if (!world) return tl::unexpected(world.error());
    world_ = std::make_shared<const WorldSpec>(std::move(*world));
  }
  auto rig = SensorRig::make(RobotModel{}, *world_, seed);
  if (!rig) return tl::unexpected(rig.error());
  rig_ = std::move(*rig);
  targets_ = targets_of(*world_, options_.classes);
  world_index_ = index;
  return {};
}

int ImageMaker::count_visible() const {
  const auto boxes = visible_boxes(preview_, rig_->instances(), 4);
  return static_cast<int>(std::count_if(boxes.begin(), boxes.end(), [this](const VisibleBox& box) {
    const Instance& instance = rig_->instances()[static_cast<std::size_t>(box.instance)];
    return instance.body < 0 || asked_for(instance.label);
  }));
}

bool ImageMaker::asked_for(const std::string& label) const {
  return std::find(options_.classes.begin(), options_.classes.end(), label) != options_.classes.end();
}

Pose ImageMaker::choose_view(Rng& rng, const CameraParams& params) {
  const bool any = varied(world_index_);
  const CameraParams preview = preview_of(params);
  std::vector<Eigen::Vector3d> targets = targets_;
  int min_visible =
      std::min(rng.integer(1, 3), static_cast<int>(targets_.size()));  // objects that shall be seen
  if (rng.chance(kElsewhere)) {
    targets = {random_place(rng, *world_)};
    min_visible = 0;
  }
  ViewRange range = any ? kAnyView : ViewRange{};
  if (options_.max_distance_m > 0) range.max_distance_m = options_.max_distance_m;
  Pose view = Pose::Identity();
  for (int attempt = 0; attempt < kMaxViews; ++attempt) {
    view = random_view(rng, *world_, targets, range);
    rig_->camera(preview, view, preview_);
    if (bad_fraction(preview_, any ? kVeryNear_m : kNear_m) > 0.03)
      continue;  // something right before the lens, or outside the room
    if (count_visible() >= min_visible) break;
  }
  return view;
}

void ImageMaker::annotate(const CameraParams& params, const Pose& world_T_optical) {
  image_.annotations.clear();
  const auto& instances = rig_->instances();
  for (const VisibleBox& box : visible_boxes(image_.images, instances, options_.min_pixels)) {
    const Instance& instance = instances[static_cast<std::size_t>(box.instance)];
    if (!asked_for(instance.label)) continue;
    Annotation note{instance.label, box};
    const int small_side = std::min(box.x_max - box.x_min, box.y_max - box.y_min) + 1;
    note.difficult = small_side < kDifficultSize;
    note.truncated = box.x_min == 0 || box.y_min == 0 || box.x_max + 1 == params.model.width ||
                     box.y_max + 1 == params.model.height;
    if (instance.body >= 0) {
      const BodySpec& body = world_->bodies[static_cast<std::size_t>(instance.body)];
      const WholeView whole = whole_view(body, params.model, world_T_optical);
      note.visible = whole.pixels > 0 ? std::min(1.0, box.pixels / whole.pixels) : 1;
      note.truncated = whole.pixels_inside < 0.99 * whole.pixels;
      note.occluded = box.pixels < kOccluded * whole.pixels_inside;
      note.difficult |= note.visible < kDifficultFraction || shows_base_only(body, world_T_optical);
    }
    image_.annotations.push_back(note);
  }
}

Result<const AnnotatedImage*> ImageMaker::make(int number) {
  if (auto entered = enter_world(number); !entered) return tl::unexpected(entered.error());
  Rng rng(mix(options_.seed ^ 0x5DEECE66DU, static_cast<std::uint64_t>(number)));
  CameraParams params;
  params.model = random_camera(rng, options_.width, options_.height);
  params.supersampling = options_.supersampling;
  params.image_noise = 0;  // apply_camera_effects() adds it after blur and exposure, as on a real sensor
  rig_->pose(snapshot_of(*world_, random_people(rng, *world_), number));
  const Pose view = choose_view(rng, params);
  const bool any = varied(world_index_);
  params.soft_light = !(any && rng.chance(0.25));
  rig_->camera(params, view, image_.images);
  if (!options_.plain)
    apply_camera_effects(rng, image_.images.rgb, options_.width, options_.height,
                         any ? CameraQuality::kPoor : CameraQuality::kUsual);
  image_.jpeg_quality = any && !options_.plain ? rng.integer(35, 95) : kJpegQuality;
  annotate(params, view);
  return &image_;
}

}  // namespace extperfc::simulate

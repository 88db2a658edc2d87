#include "ros/params/localizer_params.hpp"

#include "ros/params/param_reader.hpp"

namespace extperfc::ros_params {

namespace {

using localize::LocalizerParams;
using localize::OdometryModel;
using localize::SensorModel;

constexpr double kFar = 1e6;
constexpr int kMaxParticles = 1'000'000;

/// Parameters of amcl without effect here.
constexpr const char* kWithoutMeaning[] = {"do_beamskip",
                                           "beam_skip_distance",
                                           "beam_skip_threshold",
                                           "beam_skip_error_threshold",
                                           "beam_skip_error_threshold_",
                                           "bag_scan_period",
                                           "restore_defaults",
                                           "selective_resampling",
                                           "force_update_after_initialpose",
                                           "force_update_after_set_map"};

void read_filter(ParamReader& reader, LocalizerParams& filter) {
  int seed = static_cast<int>(filter.seed);
  reader.read("min_particles", filter.min_particles, {1, kMaxParticles});
  reader.read("max_particles", filter.max_particles, {1, kMaxParticles});
  reader.read("kld_err", filter.kld_err, {1e-6, 1.0});
  reader.read("kld_z", filter.kld_z, {0.0, 1.0});
  reader.read("update_min_d", filter.update_min_d, {0.0, kFar});
  reader.read("update_min_a", filter.update_min_a, {0.0, kFar});
  reader.read("resample_interval", filter.resample_interval, {1, 1000});
  reader.read("recovery_alpha_slow", filter.recovery_alpha_slow, {0.0, 1.0});
  reader.read("recovery_alpha_fast", filter.recovery_alpha_fast, {0.0, 1.0});
  reader.read("seed", seed, {0, 2147483647});
  filter.seed = static_cast<std::uint64_t>(seed);
}

void read_laser(ParamReader& reader, LocalizerParams& filter, std::vector<std::string>& notes) {
  std::string model = "likelihood_field";
  reader.read("laser_model_type", model);
  if (model == "beam")
    filter.sensor_model = SensorModel::kBeam;
  else if (model == "likelihood_field_prob")
    notes.emplace_back(
        "laser_model_type likelihood_field_prob: beams are not skipped here; likelihood_field is used");
  else if (model != "likelihood_field")
    reader.complain("unknown laser_model_type '" + model +
                    "'; known: likelihood_field, likelihood_field_prob, beam");
  reader.read("laser_max_beams", filter.laser_max_beams, {2, 10000});
  reader.read("laser_min_range", filter.laser_min_range, {-1.0, kFar});
  reader.read("laser_max_range", filter.laser_max_range, {-1.0, kFar});
  reader.read("laser_z_hit", filter.laser_z_hit, {0.0, kFar});
  reader.read("laser_z_short", filter.laser_z_short, {0.0, kFar});
  reader.read("laser_z_max", filter.laser_z_max, {0.0, kFar});
  reader.read("laser_z_rand", filter.laser_z_rand, {0.0, kFar});
  reader.read("laser_sigma_hit", filter.laser_sigma_hit, {1e-3, 100.0});
  reader.read("laser_lambda_short", filter.laser_lambda_short, {1e-6, kFar});
  reader.read("laser_likelihood_max_dist", filter.laser_likelihood_max_dist, {1e-3, 100.0});
}

/// The core's alphas are those of amcl's corrected models: factors of squares of motion. amcl's diff and omni
/// multiply squares where standard deviations belong; their alphas, as factors of motion, are squared here.
void read_odometry(ParamReader& reader, LocalizerParams& filter, std::vector<std::string>& notes) {
  std::string model = "diff-corrected";
  reader.read("odom_model_type", model);
  const bool faulty = model == "diff" || model == "omni";
  if (!faulty && model != "diff-corrected" && model != "omni-corrected")
    reader.complain("unknown odom_model_type '" + model +
                    "'; known: diff, omni, diff-corrected, omni-corrected");
  filter.odometry_model = model.rfind("omni", 0) == 0 ? OdometryModel::kOmni : OdometryModel::kDifferential;
  if (faulty)
    notes.push_back("odom_model_type " + model + " is faulty in amcl; " + model +
                    "-corrected is used, with the squares of odom_alpha1 to 5");
  const auto read_alpha = [&](const char* key, double& alpha) {
    reader.read(key, alpha, {0.0, 100.0});
    if (faulty) alpha *= alpha;
  };
  read_alpha("odom_alpha1", filter.odom_alpha1);
  read_alpha("odom_alpha2", filter.odom_alpha2);
  read_alpha("odom_alpha3", filter.odom_alpha3);
  read_alpha("odom_alpha4", filter.odom_alpha4);
  read_alpha("odom_alpha5", filter.odom_alpha5);
}

void read_start(ParamReader& reader, LocalizerNodeParams& params) {
  reader.read("initial_pose_x", params.initial_pose.x, {-kFar, kFar});
  reader.read("initial_pose_y", params.initial_pose.y, {-kFar, kFar});
  reader.read("initial_pose_a", params.initial_pose.yaw, {-kFar, kFar});
  reader.read("initial_cov_xx", params.initial_variance.x(), {0.0, kFar});
  reader.read("initial_cov_yy", params.initial_variance.y(), {0.0, kFar});
  reader.read("initial_cov_aa", params.initial_variance.z(), {0.0, kFar});
  params.initial_pose.yaw = wrap_angle(params.initial_pose.yaw);
}

void read_node(ParamReader& reader, LocalizerNodeParams& params) {
  reader.read_frame("odom_frame_id", params.odom_frame);
  reader.read_frame("base_frame_id", params.base_frame);
  reader.read_frame("global_frame_id", params.global_frame);
  reader.read("map_file", params.map_file);
  reader.read("use_map_topic", params.use_map_topic);
  reader.read("first_map_only", params.first_map_only);
  reader.read("tf_broadcast", params.tf_broadcast);
  reader.read("transform_tolerance", params.transform_tolerance, {0.0, 10.0});
  reader.read("tf_timeout_s", params.tf_timeout_s, {0.0, 5.0});
  reader.read("gui_publish_rate", params.gui_publish_rate, {-1.0, 1000.0});
  reader.read("save_pose_rate", params.save_pose_rate, {-1.0, 10.0});
  reader.read("idle_update_period_s", params.idle_update_period_s, {0.0, 3600.0});
  reader.read("lost_fit", params.lost_fit, {0.0, 1.0});
  reader.read("std_warn_level_x", params.warn.x_m, {0.0, kFar});
  reader.read("std_warn_level_y", params.warn.y_m, {0.0, kFar});
  reader.read("std_warn_level_yaw", params.warn.yaw_rad, {0.0, kFar});
  reader.read("timeout_s", params.timeout_s, {0.1, 3600.0});
}

/// Accepts amcl's other parameters, so that its files load; one note names those that are set.
void read_rest(ParamReader& reader, const ros::NodeHandle& handle, std::vector<std::string>& notes) {
  std::string set;
  for (const char* key : kWithoutMeaning) {
    reader.accept(key);
    if (handle.hasParam(key)) set += (set.empty() ? "" : ", ") + std::string(key);
  }
  if (!set.empty()) notes.push_back("parameters of amcl without effect here: " + set);
}

}  // namespace

Result<LocalizerNodeParams> load_localizer_params(const ros::NodeHandle& private_handle) {
  LocalizerNodeParams params;
  ParamReader reader(private_handle);
  read_filter(reader, params.filter);
  read_laser(reader, params.filter, params.notes);
  read_odometry(reader, params.filter, params.notes);
  read_start(reader, params);
  read_node(reader, params);
  read_rest(reader, private_handle, params.notes);
  if (params.base_frame == params.odom_frame || params.odom_frame == params.global_frame ||
      params.base_frame == params.global_frame)
    reader.complain(
        "odom_frame_id, base_frame_id and global_frame_id must be three different frames, but are " +
        params.odom_frame + ", " + params.base_frame + ", " + params.global_frame);
  if (const auto fits = localize::validate(params.filter); !fits) reader.complain(fits.error().message);
  if (auto finished = reader.finish(); !finished) return tl::unexpected(finished.error());
  return params;
}

void store_initial_pose(const ros::NodeHandle& private_handle, const Pose2& pose,
                        const Eigen::Matrix3d& covariance) {
  private_handle.setParam("initial_pose_x", pose.x);
  private_handle.setParam("initial_pose_y", pose.y);
  private_handle.setParam("initial_pose_a", pose.yaw);
  private_handle.setParam("initial_cov_xx", covariance(0, 0));
  private_handle.setParam("initial_cov_yy", covariance(1, 1));
  private_handle.setParam("initial_cov_aa", covariance(2, 2));
}

}  // namespace extperfc::ros_params

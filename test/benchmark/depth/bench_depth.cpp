// Accuracy and time of the depth estimators on simulated stereo depth with known truth. Run with --help.

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "extperfc/base/running_stats.hpp"
#include "extperfc/base/stopwatch.hpp"
#include "extperfc/depth/box_depth.hpp"

#include "test/benchmark/depth/cases.hpp"
#include "test/benchmark/depth/sensor.hpp"
#include "test/benchmark/report.hpp"

namespace extperfc::benchmark {
namespace {

using depth::BoxDepthParams;
using depth::Estimator;

constexpr char kHelp[] =
    "bench_depth [--seed N] [--scenes N] [--json FILE] [--image FILE]\n"
    "  --seed N        of scenes, noise and boxes (1)\n"
    "  --scenes N      per case; three boxes each (150)\n"
    "  --json FILE     write the results\n"
    "  --image FILE  write one simulated depth image (16-bit PNG) and stop\n";

constexpr char kTruth[] =
    "Truth: noise-free depth along the optical axis of the object's visible pixel nearest to the centre of "
    "its tight,\n"
    "true box. The estimators get the noisy image and a box as a detector gives it. Errors in cm.\n";

constexpr int kBoxesPerScene = 3;
constexpr double kPaperError = 1.75;  // cm, mean over 0.2 to 0.9 m that ExtPerFC reports for its robot
constexpr double kTimeGoal = 100.0;   // microseconds per box

constexpr std::array<Estimator, 4> kEstimators{Estimator::kMean, Estimator::kMedian, Estimator::kTrimmedMean,
                                               Estimator::kNearestMode};
constexpr std::size_t kColumns = kEstimators.size() + 1;  // the last: mean with zeros, for information
constexpr std::size_t kPeer = 0;
constexpr std::size_t kOurs = 3;
constexpr std::array<const char*, kColumns> kColumnNames{"mean (paper)", "median", "trimmed mean",
                                                         "nearest mode", "mean with zeros"};

struct Options {
  std::uint64_t seed{1};
  int scenes{150};
  std::string json;
  std::string image;
};

struct Score {
  std::vector<double> errors_cm;
  double squared_sigmas{0};  // sum of (error / sigma)^2
  int missing{0};
  double seconds{0};
  int calls{0};
};
using Scores = std::array<Score, kColumns>;

/// RGB of a D435i at 640 x 480.
CameraModel camera() {
  return {640, 480, 610.0, 610.0, 320.0, 240.0, {}};
}

void add(Score& score, const std::optional<depth::BoxDepth>& found, double truth_m) {
  ++score.calls;
  if (!found) {
    ++score.missing;
    return;
  }
  const double error_m = found->depth_m - truth_m;
  score.errors_cm.push_back(100.0 * std::abs(error_m));
  score.squared_sigmas += std::pow(error_m / found->sigma_m, 2);
}

void try_box(const ImageView& image, const Box2& box, double truth_m, Scores& scores) {
  for (std::size_t i = 0; i < kEstimators.size(); ++i) {
    BoxDepthParams params;
    params.estimator = kEstimators[i];
    const Stopwatch watch;
    auto found = depth::estimate_depth(image, box, params);
    scores[i].seconds += watch.seconds();
    add(scores[i], found, truth_m);
    if (i != kPeer) continue;
    if (found) found->depth_m *= found->valid_fraction;  // sum of the valid values / all pixels of the window
    add(scores.back(), found, truth_m);
  }
}

ImageView view_of(const cv::Mat& depth) {
  return {depth.data, depth.cols, depth.rows, depth.step[0], PixelFormat::kDepth16Mm};
}

Scores run_case(const Case& kind, const Options& options) {
  Rng rng(options.seed);
  const StereoSensor sensor(camera(), {});
  Scores scores;
  for (int i = 0; i < options.scenes; ++i) {
    const Rendering rendering = draw_rendering(kind, camera(), rng);
    const cv::Mat image = sensor.measure(rendering, rng);
    for (int b = 0; b < kBoxesPerScene; ++b)
      try_box(view_of(image), detected_box(rendering.box, kind.box_error, camera(), rng), rendering.truth_m,
              scores);
  }
  return scores;
}

double mean_error(const Score& score) {
  double sum = 0.0;
  for (const double e : score.errors_cm) sum += e;
  return sum / static_cast<double>(score.errors_cm.size());
}

double percentile_95(Score& score) {
  return percentile(score.errors_cm, 0.95);
}

double error_in_sigmas(const Score& score) {
  return std::sqrt(score.squared_sigmas / static_cast<double>(score.errors_cm.size()));
}

void print_header() {
  std::printf("%-18s %-16s", "case", "metric");
  for (const char* name : kColumnNames) std::printf(" %15s", name);
  std::printf("\n");
}

template <typename Metric>
void print_line(const std::string& name, const char* metric, Scores& scores, Metric value) {
  std::printf("%-18s %-16s", name.c_str(), metric);
  for (auto& score : scores) std::printf(" %15.2f", value(score));
  std::printf("\n");
}

void print_case(const std::string& name, Scores& scores) {
  print_line(name, "mean |error|", scores, mean_error);
  print_line("", "95 % |error|", scores, percentile_95);
  print_line("", "error / sigma", scores, error_in_sigmas);
  print_line("", "no estimate [%]", scores, [](const Score& s) { return 100.0 * s.missing / s.calls; });
}

/// Where the estimator has to be better than the paper's mean, and where it has to reach the paper's own
/// figure.
Row with_goal(Row row, const Case& kind) {
  if (kind.far_m <= 0.9) return at_most(row, kPaperError);
  const bool hard = kind.at_border || kind.shapes.size() > 1 || kind.shapes.front() == Shape::kCone;
  return hard ? at_most(row, *row.peer) : row;
}

void add_rows(const Case& kind, Scores& scores, std::vector<Row>& rows) {
  for (std::size_t i = 0; i < kColumns; ++i) {
    const std::string name = kColumnNames[i];
    Row mean{
        kind.name,          name + ": mean |error|", "cm", mean_error(scores[i]), mean_error(scores[kPeer]),
        kColumnNames[kPeer]};
    rows.push_back(i == kOurs ? with_goal(mean, kind) : mean);
    rows.push_back({kind.name, name + ": 95 % |error|", "cm", percentile_95(scores[i]),
                    percentile_95(scores[kPeer]), kColumnNames[kPeer]});
  }
}

void add_times(const Scores& total, std::vector<Row>& rows) {
  const auto per_box = [](const Score& score) { return 1e6 * score.seconds / score.calls; };
  for (std::size_t i = 0; i < kEstimators.size(); ++i)
    rows.push_back(at_most({"all", std::string(kColumnNames[i]) + ": time per box", "us", per_box(total[i]),
                            per_box(total[kPeer]), kColumnNames[kPeer]},
                           kTimeGoal));
}

std::vector<Row> run_all(const Options& options) {
  std::vector<Row> rows;
  Scores total;
  print_header();
  for (const auto& kind : all_cases()) {
    Scores scores = run_case(kind, options);
    print_case(kind.name, scores);
    add_rows(kind, scores, rows);
    for (std::size_t i = 0; i < kColumns; ++i) {
      total[i].seconds += scores[i].seconds;
      total[i].calls += scores[i].calls;
    }
  }
  add_times(total, rows);
  return rows;
}

bool write_image(const Options& options) {
  Rng rng(options.seed);
  const Case kind{"image", {Shape::kCone}, 0.4, 0.6};
  const Rendering rendering = draw_rendering(kind, camera(), rng);
  return cv::imwrite(options.image, StereoSensor(camera(), {}).measure(rendering, rng));
}

template <typename Number>
bool parse_number(const char* text, Number& out) {
  const char* const end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, out);
  return error == std::errc() && stop == end && out > 0;
}

bool set_option(const std::string& name, const char* value, Options& options) {
  if (name == "--seed") return parse_number(value, options.seed);
  if (name == "--scenes") return parse_number(value, options.scenes);
  if (name == "--json") return !(options.json = value).empty();
  if (name == "--image") return !(options.image = value).empty();
  return false;
}

std::optional<Options> parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2)
    if (i + 1 >= argc || !set_option(argv[i], argv[i + 1], options)) return std::nullopt;
  return options;
}

int run(const Options& options) {
  if (!options.image.empty()) return write_image(options) ? 0 : 1;
  std::printf("%s\nseed %llu, %d scenes per case, %d boxes per scene\n%s\n", machine_description().c_str(),
              static_cast<unsigned long long>(options.seed), options.scenes, kBoxesPerScene, kTruth);
  const Stopwatch watch;
  const auto rows = run_all(options);
  std::printf("\nGoals\n");
  std::vector<Row> goals;
  for (const auto& row : rows)
    if (row.goal) goals.push_back(row);
  std::fflush(stdout);
  print_table(std::cout, goals);
  std::cout << "\n" << watch.seconds() << " s\n";
  if (options.json.empty() || write_json(options.json, "depth", rows)) return 0;
  std::cerr << "bench_depth: cannot write " << options.json << "\n";
  return 1;
}

}  // namespace
}  // namespace extperfc::benchmark

int main(int argc, char** argv) {
  const bool help = argc == 2 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "-h") == 0);
  const auto options = extperfc::benchmark::parse(argc, argv);
  if (options && !help) return extperfc::benchmark::run(*options);
  (help ? std::cout : std::cerr) << extperfc::benchmark::kHelp;
  return help ? 0 : 2;
}

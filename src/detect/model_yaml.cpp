#include "detect/model_yaml.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <utility>

#include "extperfc/world/yaml_map.hpp"

#include "detect/ssd_priors.hpp"
#include "detect/yunet_levels.hpp"

namespace extperfc::detect {

namespace {

constexpr Span kMean{-1000, 1000};            // 8-bit units
constexpr Span kScale{1e-6, 1000};            // 1 / 8-bit units
constexpr Span kVariance{1e-6, 10};           // as in the SSD paper's code
constexpr Span kPriorValue{-10, 10};          // of the input's size
constexpr Span kBoxSize{1e-3, 8192};          // input pixels
constexpr Span kRatio{1e-2, 100};             // width / height
constexpr int kMinSize = 8, kMaxSize = 4096;  // pixels
constexpr int kMaxStride = 4096;              // input pixels
constexpr int kMaxCells = 1024;               // of a feature map, along one axis

float number(YamlMap& map, const std::string& key, Span span, std::optional<double> fallback = {}) {
  return static_cast<float>(map.number(key, span, fallback));
}

template <std::size_t kCount>
std::array<float, kCount> to_floats(const std::vector<double>& values) {
  std::array<float, kCount> result;
  std::transform(values.begin(), values.begin() + kCount, result.begin(),
                 [](double value) { return static_cast<float>(value); });
  return result;
}

/// Three numbers, or one for all three.
std::array<float, 3> triple(YamlMap& map, const std::string& key, Span span, double fallback) {
  if (!map.is_list(key)) {
    const float all = number(map, key, span, fallback);
    return {all, all, all};
  }
  return to_floats<3>(map.numbers(key, 3, span));
}

InputSpec parse_input(YamlMap section) {
  InputSpec input;
  input.name = section.text("name", "");
  input.width = section.integer("width", kMinSize, kMaxSize);
  input.height = section.integer("height", kMinSize, kMaxSize);
  input.bgr = section.choice("color", {"rgb", "bgr"}) == 1;
  input.resize =
      section.choice("resize", {"stretch", "letterbox"}) == 1 ? Resize::kLetterbox : Resize::kStretch;
  input.interpolation = section.choice("interpolation", {"linear", "area"}) == 1 ? Interpolation::kArea
                                                                                 : Interpolation::kLinear;
  input.mean = triple(section, "mean", kMean, 0);
  input.scale = triple(section, "scale", kScale, 1);
  section.refuse_unknown();
  return input;
}

PriorLevel parse_prior_level(YamlMap& section, const InputSpec& input) {
  PriorLevel level;
  level.stride = section.integer("stride", 1, kMaxStride);
  const int stride = level.stride;
  level.columns = section.integer("columns", 1, kMaxCells, (input.width + stride - 1) / stride);
  level.rows = section.integer("rows", 1, kMaxCells, (input.height + stride - 1) / stride);
  level.min_size = number(section, "min_size", kBoxSize);
  level.max_size = number(section, "max_size", {0, kBoxSize.high}, 0);
  for (const double ratio : section.numbers("aspect_ratios", {0, kAnyNumber}, kRatio, std::vector<double>{}))
    level.aspect_ratios.push_back(static_cast<float>(ratio));
  section.refuse_unknown();
  return level;
}

std::vector<Prior> parse_priors(YamlMap& output, const InputSpec& input) {
  std::vector<Prior> priors;
  if (output.is_list("priors")) {
    for (const auto& row : output.rows("priors", 4, kPriorValue)) {
      const auto [cx, cy, w, h] = to_floats<4>(row);
      priors.push_back({cx, cy, w, h});
    }
    return priors;
  }
  YamlMap generator = output.section("priors", true);
  if (!output.has("priors")) return priors;
  std::vector<PriorLevel> levels;
  for (YamlMap& level : generator.maps("levels", 1)) levels.push_back(parse_prior_level(level, input));
  const bool clip = generator.flag("clip", false);
  generator.refuse_unknown();
  return make_priors(levels, input.width, input.height, clip);
}

std::vector<AnchorLevel> parse_anchors(YamlMap& output) {
  std::vector<AnchorLevel> levels;
  for (YamlMap& section : output.maps("anchors", 1)) {
    AnchorLevel level;
    level.stride = section.integer("stride", 1, kMaxStride);
    for (const auto& size : section.rows("sizes", 2, kBoxSize)) level.sizes_px.push_back(to_floats<2>(size));
    section.refuse_unknown();
    levels.push_back(std::move(level));
  }
  return levels;
}

std::size_t tensor_count(const OutputSpec& output) {
  if (output.layout == OutputLayout::kSsd || output.layout == OutputLayout::kSsdPriors) return 2;
  if (output.layout == OutputLayout::kYunet) return kYunetTensors;
  return output.layout == OutputLayout::kYoloAnchors ? output.anchors.size() : 1;
}

void parse_ssd_keys(YamlMap& section, const InputSpec& input, OutputSpec& output) {
  output.background_class = section.integer("background_class", -1, 100000, -1);
  output.apply_softmax = section.flag("apply_softmax", false);
  if (output.layout != OutputLayout::kSsdPriors) return;
  output.variances = to_floats<2>(section.numbers("variances", 2, kVariance, std::vector<double>{0.1, 0.2}));
  output.priors = parse_priors(section, input);
}

OutputSpec parse_output(YamlMap section, const InputSpec& input) {
  OutputSpec output;
  const std::string layout_name = section.text("layout");
  const auto layout = layout_from_name(layout_name);
  if (!layout && !layout_name.empty())
    section.problem("layout", layout.error().message, ErrorCode::kUnsupported);
  if (!layout) return output;  // which other keys belong here is not known

  output.layout = *layout;
  if (*layout == OutputLayout::kSsd || *layout == OutputLayout::kSsdPriors)
    parse_ssd_keys(section, input, output);
  if (*layout == OutputLayout::kYoloAnchors) output.anchors = parse_anchors(section);
  output.names = section.texts("names", tensor_count(output) > 1);
  if (!output.names.empty() && output.names.size() != tensor_count(output))
    section.problem("names", "layout " + layout_name + " has " + std::to_string(tensor_count(output)) +
                                 " output tensors, but " + std::to_string(output.names.size()) +
                                 " names are listed");
  for (const char* key : {"background_class", "apply_softmax", "variances", "priors", "anchors"})
    if (!section.asked_for(key)) section.refuse(key, "is not used by layout " + layout_name + ": remove it");
  section.refuse_unknown();
  return output;
}

/// One name per line; empty lines at the end do not count.
std::vector<std::string> read_class_file(YamlMap& root, const std::filesystem::path& folder) {
  const std::string name = root.text("classes_file");
  std::ifstream stream(folder / name);
  if (!stream) {
    root.problem("classes_file", "cannot open " + (folder / name).string(), ErrorCode::kNotFound);
    return {};
  }
  std::vector<std::string> classes;
  for (std::string line; std::getline(stream, line);) {
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())) != 0) line.pop_back();
    classes.push_back(line);
  }
  while (!classes.empty() && classes.back().empty()) classes.pop_back();
  return classes;
}

std::vector<std::string> parse_classes(YamlMap& root, const std::filesystem::path& folder) {
  const bool from_file = root.has("classes_file");
  auto classes = from_file ? read_class_file(root, folder) : root.texts("classes");
  if (from_file) root.refuse("classes", "give either classes or classes_file, not both");
  std::set<std::string> seen;
  for (const std::string& name : classes)
    if (!seen.insert(name).second) root.problem("classes", "\"" + name + "\" is there twice");
  return classes;
}

Thresholds parse_thresholds(YamlMap section) {
  Thresholds thresholds;
  thresholds.score = number(section, "score", kFraction, thresholds.score);
  thresholds.nms_iou = number(section, "nms_iou", kFraction, thresholds.nms_iou);
  thresholds.max_detections = section.integer("max_detections", 1, 10000, thresholds.max_detections);
  section.refuse_unknown();
  return thresholds;
}

void check_yunet(const ModelSpec& spec, const YamlMap& root) {
  if (spec.classes.size() > 1) root.problem("classes", "layout yunet finds one class: list one name");
  if (spec.input.width % kYunetStrides.back() != 0 || spec.input.height % kYunetStrides.back() != 0)
    root.problem("input", "layout yunet needs a width and a height that are multiples of " +
                              std::to_string(kYunetStrides.back()));
}

std::string parse_sha256(YamlMap& root) {
  std::string digits = root.text("sha256", "");
  std::transform(digits.begin(), digits.end(), digits.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool hexadecimal = digits.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (!digits.empty() && (digits.size() != 64 || !hexadecimal))
    root.problem("sha256", "must be 64 hexadecimal digits, as sha256sum prints them");
  return digits;
}

}  // namespace

ModelSpec parse_model_yaml(const YAML::Node& root_node, const std::filesystem::path& folder,
                           Problems& problems) {
  YamlMap root(root_node, "", problems);
  ModelSpec spec;
  spec.folder = folder;
  spec.name = root.text("name");
  spec.file = folder / root.text("file");
  spec.sha256 = parse_sha256(root);
  spec.input = parse_input(root.section("input", true));
  spec.output = parse_output(root.section("output", true), spec.input);
  if (spec.output.layout == OutputLayout::kVector)
    for (const char* key : {"classes", "classes_file", "thresholds"})
      root.refuse(key, "is not used by layout vector: remove it");
  else
    spec.classes = parse_classes(root, folder);
  spec.thresholds = parse_thresholds(root.section("thresholds", false));
  spec.source = root.text("source", "");
  spec.license = root.text("license", "");
  root.refuse_unknown();
  const int columns = static_cast<int>(spec.classes.size());
  if (spec.output.layout == OutputLayout::kYunet) check_yunet(spec, root);
  if (spec.output.background_class > columns)
    root.problem("output.background_class", "must be in [-1, " + std::to_string(columns) + "]");
  return spec;
}

}  // namespace extperfc::detect

#include "detect/model_yaml.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>
#include <utility>

#include "detect/ssd_priors.hpp"

namespace extperfc::detect {

namespace {

constexpr Range<int> kInputSize{8, 4096};           // pixels
constexpr Range<float> kMean{-1000.0F, 1000.0F};    // 8-bit units
constexpr Range<float> kScale{1e-6F, 1000.0F};      // 1 / 8-bit units
constexpr Range<float> kFraction{0.0F, 1.0F};       // of 1
constexpr Range<float> kVariance{1e-6F, 10.0F};     // as in the SSD paper's code
constexpr Range<float> kPriorValue{-10.0F, 10.0F};  // of the input's size
constexpr Range<float> kBoxSize{1e-3F, 8192.0F};    // input pixels
constexpr Range<float> kRatio{1e-2F, 100.0F};       // width / height
constexpr Range<int> kStride{1, 4096};              // input pixels
constexpr Range<int> kCells{1, 1024};               // of a feature map, along one axis

std::array<float, 3> triple(const std::vector<float>& values) {
  return {values[0], values[1], values[2]};
}

/// One of two names; the first is the default.
bool second_of(YamlSection& section, const std::string& key, const std::string& first,
               const std::string& second) {
  const std::string name = section.text(key, first);
  if (name != first && name != second)
    section.problem(key, "must be " + first + " or " + second + ", not \"" + name + "\"");
  return name == second;
}

InputSpec parse_input(YamlSection section) {
  InputSpec input;
  input.name = section.text("name", "");
  input.width = section.integer("width", kInputSize);
  input.height = section.integer("height", kInputSize);
  input.bgr = second_of(section, "color", "rgb", "bgr");
  input.resize = second_of(section, "resize", "stretch", "letterbox") ? Resize::kLetterbox : Resize::kStretch;
  input.interpolation =
      second_of(section, "interpolation", "linear", "area") ? Interpolation::kArea : Interpolation::kLinear;
  input.mean = triple(section.numbers("mean", 3, kMean, std::vector<float>(3, 0.0F), true));
  input.scale = triple(section.numbers("scale", 3, kScale, std::vector<float>(3, 1.0F), true));
  section.refuse_unknown();
  return input;
}

PriorLevel parse_prior_level(YamlSection& section, const InputSpec& input) {
  PriorLevel level;
  level.stride = section.integer("stride", kStride);
  const int stride = level.stride;
  level.columns = section.integer("columns", kCells, (input.width + stride - 1) / stride);
  level.rows = section.integer("rows", kCells, (input.height + stride - 1) / stride);
  level.min_size = section.number("min_size", kBoxSize);
  level.max_size = section.number("max_size", {0.0F, kBoxSize.high}, 0.0F);
  level.aspect_ratios = section.number_list("aspect_ratios", kRatio);
  section.refuse_unknown();
  return level;
}

std::vector<Prior> parse_priors(YamlSection& output, const InputSpec& input) {
  std::vector<Prior> priors;
  if (output.is_list("priors")) {
    for (const auto& row : output.rows("priors", 4, kPriorValue))
      priors.push_back({row[0], row[1], row[2], row[3]});
    return priors;
  }
  YamlSection generator = output.section("priors", true);
  if (!output.has("priors")) return priors;
  std::vector<PriorLevel> levels;
  for (YamlSection& level : generator.sections("levels")) levels.push_back(parse_prior_level(level, input));
  const bool clip = generator.flag("clip", false);
  generator.refuse_unknown();
  return make_priors(levels, input.width, input.height, clip);
}

std::vector<AnchorLevel> parse_anchors(YamlSection& output) {
  std::vector<AnchorLevel> levels;
  for (YamlSection& section : output.sections("anchors")) {
    AnchorLevel level;
    level.stride = section.integer("stride", kStride);
    for (const auto& size : section.rows("sizes", 2, kBoxSize)) level.sizes_px.push_back({size[0], size[1]});
    section.refuse_unknown();
    levels.push_back(std::move(level));
  }
  return levels;
}

std::size_t tensor_count(const OutputSpec& output) {
  if (output.layout == OutputLayout::kSsd || output.layout == OutputLayout::kSsdPriors) return 2;
  return output.layout == OutputLayout::kYoloAnchors ? output.anchors.size() : 1;
}

void parse_ssd_keys(YamlSection& section, const InputSpec& input, OutputSpec& output) {
  output.background_class = section.integer("background_class", {-1, 100000}, -1);
  output.apply_softmax = section.flag("apply_softmax", false);
  if (output.layout != OutputLayout::kSsdPriors) return;
  const auto variances = section.numbers("variances", 2, kVariance, std::vector<float>{0.1F, 0.2F});
  output.variances = {variances[0], variances[1]};
  output.priors = parse_priors(section, input);
}

OutputSpec parse_output(YamlSection section, const InputSpec& input) {
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
std::vector<std::string> read_class_file(YamlSection& root, const std::filesystem::path& folder) {
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

std::vector<std::string> parse_classes(YamlSection& root, const std::filesystem::path& folder) {
  const bool from_file = root.has("classes_file");
  auto classes = from_file ? read_class_file(root, folder) : root.texts("classes");
  if (from_file) root.refuse("classes", "give either classes or classes_file, not both");
  std::set<std::string> seen;
  for (const std::string& name : classes)
    if (!seen.insert(name).second) root.problem("classes", "\"" + name + "\" is there twice");
  return classes;
}

Thresholds parse_thresholds(YamlSection section) {
  Thresholds thresholds;
  thresholds.score = section.number("score", kFraction, thresholds.score);
  thresholds.nms_iou = section.number("nms_iou", kFraction, thresholds.nms_iou);
  thresholds.max_detections = section.integer("max_detections", {1, 10000}, thresholds.max_detections);
  section.refuse_unknown();
  return thresholds;
}

std::string parse_sha256(YamlSection& root) {
  std::string digits = root.text("sha256", "");
  std::transform(digits.begin(), digits.end(), digits.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const bool hexadecimal = digits.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (!digits.empty() && (digits.size() != 64 || !hexadecimal))
    root.problem("sha256", "must be 64 hexadecimal digits, as sha256sum prints them");
  return digits;
}

}  // namespace

Result<YAML::Node> read_yaml(const std::filesystem::path& file) {
  try {
    return YAML::LoadFile(file.string());
  } catch (const YAML::BadFile&) {
    return fail(ErrorCode::kNotFound, "cannot open " + file.string());
  } catch (const YAML::Exception& error) {
    return fail(ErrorCode::kCorrupt, file.string() + " is not YAML: line " +
                                         std::to_string(error.mark.line + 1) + ", column " +
                                         std::to_string(error.mark.column + 1) + ": " + error.msg);
  }
}

ModelSpec parse_model_yaml(const YAML::Node& root_node, const std::filesystem::path& folder,
                           Problems& problems) {
  YamlSection root(root_node, "", problems);
  ModelSpec spec;
  spec.folder = folder;
  spec.name = root.text("name");
  spec.file = folder / root.text("file");
  spec.sha256 = parse_sha256(root);
  spec.input = parse_input(root.section("input", true));
  spec.output = parse_output(root.section("output", true), spec.input);
  spec.classes = parse_classes(root, folder);
  spec.thresholds = parse_thresholds(root.section("thresholds", false));
  spec.source = root.text("source", "");
  spec.license = root.text("license", "");
  root.refuse_unknown();
  const int columns = static_cast<int>(spec.classes.size());
  if (spec.output.background_class > columns)
    root.problem("output.background_class", "must be in [-1, " + std::to_string(columns) + "]");
  return spec;
}

}  // namespace extperfc::detect

#include "extperfc/world/map_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <locale>
#include <optional>
#include <sstream>
#include <string>

#include <yaml-cpp/yaml.h>

#include "extperfc/base/atomic_file.hpp"

#include "world/pgm.hpp"

namespace extperfc {

namespace {

namespace fs = std::filesystem;

// Grey values of map_saver.
constexpr std::uint8_t kGreyOccupied = 0;
constexpr std::uint8_t kGreyFree = 254;
constexpr std::uint8_t kGreyUnknown = 205;

enum class MapMode { kTrinary, kScale, kRaw };

/// What stands in the YAML file.
struct MapDescription {
  fs::path image;
  double resolution_m{0};
  Pose2 origin;
  bool negate{false};
  MapThresholds thresholds;
  MapMode mode{MapMode::kTrinary};
};

Result<void> validate(const MapThresholds& thresholds) {
  if (thresholds.free > 0 && thresholds.free < thresholds.occupied && thresholds.occupied < 1) return {};
  return fail(ErrorCode::kInvalidArgument, "thresholds must be 0 < free < occupied < 1, not free " +
                                               std::to_string(thresholds.free) + " and occupied " +
                                               std::to_string(thresholds.occupied));
}

Result<void> validate(const OccupancyGrid& map) {
  if (map.width == 0 || map.height == 0) return fail(ErrorCode::kInvalidArgument, "the map has no cells");
  if (map.height > kMaxMapCells / map.width)
    return fail(ErrorCode::kInvalidArgument, "the map has more than 2^28 cells");
  if (map.cells.size() != map.width * map.height)
    return fail(ErrorCode::kInvalidArgument, "the map holds " + std::to_string(map.cells.size()) +
                                                 " cells and is said to have " + std::to_string(map.width) +
                                                 " x " + std::to_string(map.height));
  const bool finite =
      std::isfinite(map.origin.x) && std::isfinite(map.origin.y) && std::isfinite(map.origin.yaw);
  if (!finite || !std::isfinite(map.resolution_m) || map.resolution_m <= 0)
    return fail(ErrorCode::kInvalidArgument, "the map's origin or resolution is not a usable number");
  return {};
}

std::array<std::uint8_t, 256> grey_values(const MapThresholds& thresholds) {
  std::array<std::uint8_t, 256> grey{};
  constexpr double kTiny = 1e-9;  // 65 of 100 is 0.65 despite rounding
  for (int value = 0; value < 256; ++value) {
    const auto cell = static_cast<std::int8_t>(value);
    const double probability = cell / 100.0;
    auto& pixel = grey[static_cast<std::size_t>(value)];
    pixel = kGreyUnknown;
    if (cell >= 0 && probability <= thresholds.free + kTiny) pixel = kGreyFree;
    if (cell >= 0 && probability >= thresholds.occupied - kTiny) pixel = kGreyOccupied;
  }
  return grey;
}

void write_pgm(std::ostream& out, const OccupancyGrid& map, const MapThresholds& thresholds) {
  out << "P5\n# CREATOR: extperfc " << std::fixed << std::setprecision(3) << map.resolution_m << " m/pix\n"
      << map.width << ' ' << map.height << "\n255\n";
  const auto grey = grey_values(thresholds);
  std::string row(map.width, '\0');
  for (std::size_t y = map.height; y-- > 0;) {
    const auto* cells = &map.cells[y * map.width];
    std::transform(cells, cells + map.width, row.begin(), [&](std::int8_t cell) {
      return static_cast<char>(grey[static_cast<std::uint8_t>(cell)]);
    });
    out.write(row.data(), static_cast<std::streamsize>(row.size()));
  }
}

void write_yaml(std::ostream& out, const OccupancyGrid& map, const std::string& image,
                const MapThresholds& thresholds) {
  YAML::Emitter name;  // quotes what YAML would read otherwise
  name << image;
  out << "image: " << name.c_str() << '\n'
      << std::setprecision(12) << "resolution: " << map.resolution_m << "\norigin: [" << map.origin.x << ", "
      << map.origin.y << ", " << map.origin.yaw << "]\nnegate: 0\noccupied_thresh: " << thresholds.occupied
      << "\nfree_thresh: " << thresholds.free << "\n\n";
}

/// Text of a key; empty when it is not there. Kept apart from yaml-cpp's conversions, which throw.
std::optional<std::string> text_of(const YAML::Node& node) {
  if (!node.IsDefined() || !node.IsScalar()) return std::nullopt;
  return node.Scalar();
}

std::optional<double> number_of(const YAML::Node& node) {
  const auto text = text_of(node);
  if (!text) return std::nullopt;
  std::istringstream in(*text);
  in.imbue(std::locale::classic());
  double value = 0;
  if (!(in >> value) || !std::isfinite(value)) return std::nullopt;
  in >> std::ws;
  if (!in.eof()) return std::nullopt;
  return value;
}

/// Reads keys and remembers the first that is wrong.
class Keys {
 public:
  explicit Keys(const YAML::Node& root) : root_(root) {}

  double number(const char* key) {
    const auto value = number_of(root_[key]);
    if (!value) complain(key, root_[key].IsDefined() ? "is not a number" : "is missing");
    return value.value_or(0);
  }

  Pose2 pose(const char* key) {
    const YAML::Node node = root_[key];
    constexpr std::size_t kCoordinates = 3;
    std::array<double, kCoordinates> value{};
    const bool is_list = node.IsDefined() && node.IsSequence() && node.size() >= kCoordinates;
    for (std::size_t i = 0; i < kCoordinates; ++i) {
      const auto number = is_list ? number_of(node[i]) : std::nullopt;
      if (!number) {
        complain(key, node.IsDefined() ? "is not a list of three numbers [x, y, yaw]" : "is missing");
        return {};
      }
      value[i] = *number;
    }
    return {value[0], value[1], value[2]};
  }

  std::string text(const char* key) {
    const auto value = text_of(root_[key]);
    if (!value || value->empty())
      complain(key, root_[key].IsDefined() ? "is not a file's name" : "is missing");
    return value.value_or("");
  }

  /// map_server writes 0 and 1; people write true and false.
  bool flag(const char* key) {
    const auto value = text_of(root_[key]);
    if (!value)
      complain(key, root_[key].IsDefined() ? "is neither 0 nor 1" : "is missing");
    else if (*value == "1" || *value == "true" || *value == "True")
      return true;
    else if (*value != "0" && *value != "false" && *value != "False")
      complain(key, "is neither 0 nor 1");
    return false;
  }

  MapMode mode() {
    if (!root_["mode"].IsDefined()) return MapMode::kTrinary;
    const auto value = text_of(root_["mode"]);
    if (value == "scale") return MapMode::kScale;
    if (value == "raw") return MapMode::kRaw;
    if (value != "trinary") complain("mode", "must be trinary, scale or raw");
    return MapMode::kTrinary;
  }

  void complain(const std::string& key, const std::string& what) {
    if (complaint_.empty()) complaint_ = "'" + key + "' " + what;
  }
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  YAML::Node root_;
  std::string complaint_;
};

Result<YAML::Node> read_yaml(const fs::path& file) {
  std::error_code error;
  const auto bytes = fs::file_size(file, error);
  std::ifstream in(file);
  if (error || !in) return fail(ErrorCode::kNotFound, "cannot read the map " + file.string());
  constexpr std::uintmax_t kMaxBytes = 1 << 20;
  if (bytes > kMaxBytes)
    return fail(ErrorCode::kCorrupt,
                file.string() + " is too large for a map's description; give the .yaml file of the map");
  try {
    YAML::Node root = YAML::Load(in);
    if (root.IsMap()) return root;
  } catch (const YAML::Exception& e) {
    return fail(ErrorCode::kCorrupt,
                file.string() + " line " + std::to_string(e.mark.line + 1) + ": " + e.msg);
  }
  return fail(ErrorCode::kCorrupt, file.string() +
                                       " is not a map's description (image, resolution, origin, negate, "
                                       "occupied_thresh, free_thresh)");
}

Result<MapDescription> describe(const fs::path& file) {
  const auto root = read_yaml(file);
  if (!root) return tl::unexpected(root.error());
  Keys keys(*root);
  MapDescription map;
  map.image = keys.text("image");
  map.resolution_m = keys.number("resolution");
  map.origin = keys.pose("origin");
  map.negate = keys.flag("negate");
  map.thresholds = {keys.number("occupied_thresh"), keys.number("free_thresh")};
  map.mode = keys.mode();
  if (map.resolution_m <= 0) keys.complain("resolution", "must be above 0");
  if (const auto valid = validate(map.thresholds); !valid)
    keys.complain("free_thresh", "and occupied_thresh do not fit: " + valid.error().message);
  if (!keys.complaint().empty()) return fail(ErrorCode::kCorrupt, file.string() + ": " + keys.complaint());
  if (map.image.is_relative()) map.image = file.parent_path() / map.image;
  return map;
}

/// What a grey value from 0 to 255 means, as map_server has it.
std::int8_t cell_of_grey(double grey, const MapDescription& map) {
  if (map.negate) grey = 255 - grey;
  if (map.mode == MapMode::kRaw)
    return grey <= OccupancyGrid::kOccupied ? static_cast<std::int8_t>(grey) : OccupancyGrid::kUnknown;
  const double occupied = (255 - grey) / 255;
  const auto& limit = map.thresholds;
  if (occupied > limit.occupied) return OccupancyGrid::kOccupied;
  if (occupied < limit.free) return OccupancyGrid::kFree;
  if (map.mode == MapMode::kTrinary) return OccupancyGrid::kUnknown;
  return static_cast<std::int8_t>(1 + 98 * (occupied - limit.free) / (limit.occupied - limit.free));
}

}  // namespace

Result<void> save_map(const OccupancyGrid& map, const fs::path& stem, const MapThresholds& thresholds) {
  for (const auto& valid : {validate(map), validate(thresholds)})
    if (!valid)
      return fail(valid.error().code, "cannot save " + stem.string() + ": " + valid.error().message);
  if (!stem.has_filename())
    return fail(ErrorCode::kInvalidArgument,
                "cannot save a map as '" + stem.string() + "': give a file's name without its suffix");
  const fs::path image = stem.string() + ".pgm";
  auto written = write_file_atomically(image, [&](std::ostream& out) { write_pgm(out, map, thresholds); });
  if (!written) return written;
  return write_file_atomically(stem.string() + ".yaml", [&](std::ostream& out) {
    write_yaml(out, map, image.filename().string(), thresholds);
  });
}

Result<OccupancyGrid> load_map(const fs::path& yaml) {
  const auto description = describe(yaml);
  if (!description) return tl::unexpected(description.error());
  const auto image = read_pgm(description->image);
  if (!image) return tl::unexpected(image.error());
  OccupancyGrid map;
  map.width = image->width;
  map.height = image->height;
  map.resolution_m = description->resolution_m;
  map.origin = description->origin;
  std::vector<std::int8_t> meaning(image->largest + std::size_t{1});
  for (std::size_t value = 0; value < meaning.size(); ++value)
    meaning[value] = cell_of_grey(255.0 * static_cast<double>(value) / image->largest, *description);
  map.cells.resize(map.width * map.height);
  for (std::size_t y = 0; y < map.height; ++y)
    for (std::size_t x = 0; x < map.width; ++x)
      map.cells[(map.height - 1 - y) * map.width + x] = meaning[image->at(x, y)];
  return map;
}

}  // namespace extperfc

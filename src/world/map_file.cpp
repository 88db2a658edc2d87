#include "extperfc/world/map_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <string>

#include <yaml-cpp/yaml.h>

#include "extperfc/base/atomic_file.hpp"
#include "extperfc/world/png_file.hpp"
#include "extperfc/world/yaml_map.hpp"

#include "world/pgm.hpp"
#include "world/png.hpp"

namespace extperfc {

namespace {

namespace fs = std::filesystem;

// Grey values of map_saver.
constexpr std::uint8_t kGreyOccupied = 0;
constexpr std::uint8_t kGreyFree = 254;
constexpr std::uint8_t kGreyUnknown = 205;

constexpr Span kResolution{1e-6, 1e6};  // [m]

const std::vector<std::string> kModes{"trinary", "scale", "raw"};  // in the order of MapMode

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
  if (!is_finite(map.origin) || !std::isfinite(map.resolution_m) || map.resolution_m <= 0)
    return fail(ErrorCode::kInvalidArgument, "the map's origin or resolution is not a usable number");
  return {};
}

/// Grey values of a map's cells by their bits.
using GreyValues = std::array<std::uint8_t, 256>;

std::uint8_t trinary_grey(int percent, const MapThresholds& thresholds) {
  constexpr double kTiny = 1e-9;  // 65 of 100 is 0.65 despite rounding
  const double probability = percent / 100.0;
  if (percent >= 0 && probability <= thresholds.free + kTiny) return kGreyFree;
  if (percent >= 0 && probability >= thresholds.occupied - kTiny) return kGreyOccupied;
  return kGreyUnknown;
}

/// The grey value in the middle of those that are read as `percent`; 99 does not exist and becomes 98.
std::uint8_t scaled_grey(int percent, const MapThresholds& thresholds) {
  if (percent < 0) return kGreyUnknown;
  if (percent == OccupancyGrid::kFree) return kGreyFree;
  if (percent >= OccupancyGrid::kOccupied) return kGreyOccupied;
  const double ratio = (std::min(percent, 98) - 0.5) / 98;
  const double probability = thresholds.free + ratio * (thresholds.occupied - thresholds.free);
  return static_cast<std::uint8_t>(std::lround(255 * (1 - probability)));
}

GreyValues grey_values(const MapThresholds& thresholds, MapMode mode) {
  constexpr std::uint8_t kRawUnknown = 255;
  GreyValues grey{};
  for (int value = 0; value < 256; ++value) {
    const int percent = value < 128 ? value : value - 256;
    const bool is_known = percent >= 0 && percent <= OccupancyGrid::kOccupied;
    auto& pixel = grey[static_cast<std::size_t>(value)];
    if (mode == MapMode::kTrinary) pixel = trinary_grey(percent, thresholds);
    if (mode == MapMode::kScale) pixel = scaled_grey(percent, thresholds);
    if (mode == MapMode::kRaw) pixel = is_known ? static_cast<std::uint8_t>(percent) : kRawUnknown;
  }
  return grey;
}

void write_pgm(std::ostream& out, const OccupancyGrid& map, const GreyValues& grey) {
  out << "P5\n# CREATOR: extperfc " << std::fixed << std::setprecision(3) << map.resolution_m << " m/pix\n"
      << map.width << ' ' << map.height << "\n255\n";
  std::string row(map.width, '\0');
  for (std::size_t y = map.height; y-- > 0;) {
    const auto* cells = &map.cells[y * map.width];
    std::transform(cells, cells + map.width, row.begin(), [&](std::int8_t cell) {
      return static_cast<char>(grey[static_cast<std::uint8_t>(cell)]);
    });
    out.write(row.data(), static_cast<std::streamsize>(row.size()));
  }
}

Result<void> write_png_map(const OccupancyGrid& map, const GreyValues& grey, bool with_alpha,
                           const fs::path& file) {
  constexpr std::uint8_t kOpaque = 255;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(map.cells.size() * (with_alpha ? 2 : 1));
  for (std::size_t y = map.height; y-- > 0;) {
    for (std::size_t x = 0; x < map.width; ++x) {
      const std::int8_t cell = map.at(x, y);
      bytes.push_back(grey[static_cast<std::uint8_t>(cell)]);
      if (with_alpha) bytes.push_back(cell < 0 ? 0 : kOpaque);
    }
  }
  const auto layout = with_alpha ? PngLayout::kGreyAlpha : PngLayout::kGrey;
  return write_png({map.width, map.height, layout, bytes.data()}, file);
}

Result<void> write_image(const OccupancyGrid& map, const MapThresholds& thresholds, const MapFormat& format,
                         const fs::path& file) {
  const GreyValues grey = grey_values(thresholds, format.mode);
  const bool scaled = format.mode == MapMode::kScale;
  if (format.image == MapImage::kPng) return write_png_map(map, grey, scaled, file);
  if (scaled && std::any_of(map.cells.begin(), map.cells.end(), [](std::int8_t cell) { return cell < 0; }))
    return fail(ErrorCode::kInvalidArgument,
                "cannot save " + file.string() + ": mode scale with unknown cells needs PNG");
  return write_file_atomically(file, [&](std::ostream& out) { write_pgm(out, map, grey); });
}

void write_yaml(std::ostream& out, const OccupancyGrid& map, const std::string& image,
                const MapThresholds& thresholds, MapMode mode) {
  YAML::Emitter name;  // quotes what YAML would read otherwise
  name << image;
  out << "image: " << name.c_str() << '\n'
      << std::setprecision(12) << "resolution: " << map.resolution_m << "\norigin: [" << map.origin.x << ", "
      << map.origin.y << ", " << map.origin.yaw << "]\nnegate: 0\noccupied_thresh: " << thresholds.occupied
      << "\nfree_thresh: " << thresholds.free << '\n';
  if (mode != MapMode::kTrinary) out << "mode: " << kModes[static_cast<std::size_t>(mode)] << '\n';
  out << '\n';
}

Result<MapDescription> describe(const fs::path& file) {
  Problems problems(file.string(), ErrorCode::kCorrupt);
  std::error_code error;
  constexpr std::uintmax_t kMaxBytes = 1 << 20;
  if (const auto bytes = fs::file_size(file, error); !error && bytes > kMaxBytes)
    return fail(ErrorCode::kCorrupt,
                file.string() + " is too large for a map's description; give the .yaml file of the map");
  const auto root = load_yaml(file, problems);
  if (!root) return tl::unexpected(problems.to_error());
  YamlMap keys(*root, "", problems);
  MapDescription map;
  map.image = keys.text("image");
  map.resolution_m = keys.number("resolution", kResolution);
  const auto origin = keys.numbers("origin", {3, kAnyNumber}, kFinite);
  map.origin = {origin[0], origin[1], origin[2]};
  map.negate = keys.flag("negate");
  map.thresholds = {keys.number("occupied_thresh", kFinite), keys.number("free_thresh", kFinite)};
  map.mode = static_cast<MapMode>(keys.choice("mode", kModes));
  if (const auto valid = validate(map.thresholds); problems.empty() && !valid)
    keys.problem("free_thresh", valid.error().message);
  if (!problems.empty()) return tl::unexpected(problems.to_error());
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

Result<void> save_map(const OccupancyGrid& map, const fs::path& stem, const MapThresholds& thresholds,
                      const MapFormat& format) {
  for (const auto& valid : {validate(map), validate(thresholds)})
    if (!valid)
      return fail(valid.error().code, "cannot save " + stem.string() + ": " + valid.error().message);
  if (!stem.has_filename())
    return fail(ErrorCode::kInvalidArgument,
                "cannot save a map as '" + stem.string() + "': give a file's name without its suffix");
  const fs::path image = stem.string() + (format.image == MapImage::kPng ? ".png" : ".pgm");
  auto written = write_image(map, thresholds, format, image);
  if (!written) return written;
  return write_file_atomically(stem.string() + ".yaml", [&](std::ostream& out) {
    write_yaml(out, map, image.filename().string(), thresholds, format.mode);
  });
}

Result<OccupancyGrid> load_map(const fs::path& yaml) {
  const auto description = describe(yaml);
  if (!description) return tl::unexpected(description.error());
  const auto image = is_png(description->image) ? read_png(description->image) : read_pgm(description->image);
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
      map.cells[(map.height - 1 - y) * map.width + x] =
          image->is_transparent(x, y) ? OccupancyGrid::kUnknown : meaning[image->at(x, y)];
  return map;
}

}  // namespace extperfc

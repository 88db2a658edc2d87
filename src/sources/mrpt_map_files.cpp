#include <array>
#include <cmath>
#include <exception>
#include <functional>
#include <string>
#include <utility>

#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <mrpt/core/Clock.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/archiveFrom_std_streams.h>

#include "extperfc/base/atomic_file.hpp"

#include "sources/mrpt_errors.hpp"
#include "sources/mrpt_map_entry.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;
using mrpt::maps::COccupancyGridMap2D;
using mrpt::obs::CObservation2DRangeScan;

constexpr std::size_t kMaxCells = std::size_t{1} << 28U;
constexpr int kMaxLogOdds = 127;  ///< of a cell of MRPT's: sixteenths
static_assert(COccupancyGridMap2D::OCCGRID_CELLTYPE_MAX == kMaxLogOdds, "MRPT's cells are bytes");
constexpr double kMaxShift = 0.01;  ///< of a cell, by which an origin may miss a multiple of the resolution
constexpr double kWholeUm = 1e6;    ///< MRPT keeps lengths as floats: read as whole micrometres

std::size_t index_of(std::int8_t value) {
  return static_cast<std::uint8_t>(value);
}

/// The value whose probability of free is nearest. MRPT's own p2l() looks into a table of 128 entries and
/// takes 49 and 51 percent for unknown.
COccupancyGridMap2D::cellType nearest_cell(float free) {
  COccupancyGridMap2D::cellType nearest = 0;
  for (int value = -kMaxLogOdds; value <= kMaxLogOdds; ++value) {
    const auto cell = static_cast<COccupancyGridMap2D::cellType>(value);
    if (std::abs(COccupancyGridMap2D::l2p(cell) - free) < std::abs(COccupancyGridMap2D::l2p(nearest) - free))
      nearest = cell;
  }
  return nearest;
}

/// What each of our cells is in MRPT, by index_of(). Unknown: even odds.
std::array<COccupancyGridMap2D::cellType, 256> mrpt_cells() {
  std::array<COccupancyGridMap2D::cellType, 256> cells{};
  for (int percent = 0; percent <= OccupancyGrid::kOccupied; ++percent)
    cells[static_cast<std::size_t>(percent)] =
        nearest_cell(1.0F - static_cast<float>(percent) / OccupancyGrid::kOccupied);
  return cells;
}

/// What each of MRPT's cells is here, by index_of().
std::array<std::int8_t, 256> our_cells() {
  std::array<std::int8_t, 256> cells{};
  for (int value = -kMaxLogOdds - 1; value <= kMaxLogOdds; ++value) {
    const auto cell = static_cast<std::int8_t>(value);
    const double occupied = 1.0 - static_cast<double>(COccupancyGridMap2D::l2p(cell));
    cells[index_of(cell)] = cell == 0
                                ? OccupancyGrid::kUnknown
                                : static_cast<std::int8_t>(std::lround(OccupancyGrid::kOccupied * occupied));
  }
  return cells;
}

/// The distance of a length from the next multiple of the resolution [cells].
double off_by(double length_m, double resolution_m) {
  const double cells = length_m / resolution_m;
  return std::abs(cells - std::round(cells));
}

Result<void> check(const OccupancyGrid& map) {
  const auto bad = [](const std::string& what) { return fail(ErrorCode::kInvalidArgument, what); };
  if (map.width == 0 || map.height == 0 || map.cells.size() != map.width * map.height)
    return bad("the map has no cells, or their number does not match its size");
  if (map.cells.size() > kMaxCells) return bad("the map has more than 2^28 cells");
  const auto& origin = map.origin;
  if (!std::isfinite(map.resolution_m) || map.resolution_m <= 0 || !std::isfinite(origin.x) ||
      !std::isfinite(origin.y))
    return bad("the map's origin or resolution is not finite or not positive");
  if (origin.yaw != 0) return bad("maps of MRPT cannot be rotated, but this one's origin has a yaw");
  if (off_by(origin.x, map.resolution_m) > kMaxShift || off_by(origin.y, map.resolution_m) > kMaxShift)
    return bad("the map's origin must be a multiple of its resolution, as MRPT requires");
  return {};
}

Result<COccupancyGridMap2D> to_mrpt(const OccupancyGrid& map) {
  const auto side = static_cast<float>(map.resolution_m);
  const double right = map.origin.x + static_cast<double>(map.width) * map.resolution_m;
  const double top = map.origin.y + static_cast<double>(map.height) * map.resolution_m;
  COccupancyGridMap2D grid;
  grid.setSize(static_cast<float>(map.origin.x), static_cast<float>(right), static_cast<float>(map.origin.y),
               static_cast<float>(top), side);
  if (grid.getSizeX() < map.width || grid.getSizeY() < map.height)
    return fail(ErrorCode::kFailed, "MRPT makes a grid of " + std::to_string(grid.getSizeX()) + " x " +
                                        std::to_string(grid.getSizeY()) + " cells for the map's " +
                                        std::to_string(map.width) + " x " + std::to_string(map.height));
  const auto meaning = mrpt_cells();
  for (std::size_t row = 0; row < map.height; ++row) {
    auto* cells = grid.getRow(static_cast<int>(row));
    for (std::size_t column = 0; column < map.width; ++column)
      cells[column] = meaning[index_of(map.at(column, row))];
  }
  return grid;
}

double metres(float length) {
  return std::round(static_cast<double>(length) * kWholeUm) / kWholeUm;
}

Result<OccupancyGrid> from_mrpt(const COccupancyGridMap2D& grid) {
  OccupancyGrid map;
  map.width = grid.getSizeX();
  map.height = grid.getSizeY();
  map.resolution_m = metres(grid.getResolution());
  map.origin = {metres(grid.getXMin()), metres(grid.getYMin()), 0};
  if (map.width == 0 || map.height == 0 || !(map.resolution_m > 0) || map.width > kMaxCells / map.height ||
      !std::isfinite(map.origin.x) || !std::isfinite(map.origin.y))
    return fail(ErrorCode::kCorrupt,
                "holds a grid without cells, without a resolution, or with too many cells");
  const auto meaning = our_cells();
  map.cells.reserve(map.width * map.height);
  for (std::size_t row = 0; row < map.height; ++row) {
    const auto* cells = grid.getRow(static_cast<int>(row));
    for (std::size_t column = 0; column < map.width; ++column)
      map.cells.push_back(meaning[index_of(cells[column])]);
  }
  return map;
}

mrpt::poses::CPose3D mrpt_pose(const Pose2& pose) {
  return mrpt::poses::CPose3D(mrpt::poses::CPose2D(pose.x, pose.y, pose.yaw));
}

/// MRPT's rays lie evenly about the sensor's x axis, so that axis is rotated into their middle.
CObservation2DRangeScan::Ptr to_mrpt(const LaserScan& scan) {
  auto observation = CObservation2DRangeScan::Create();
  const double sweep_rad = scan.angle_increment * static_cast<double>(scan.ranges.size() - 1);
  observation->timestamp = mrpt::Clock::fromDouble(scan.stamp_s);
  observation->sensorLabel = "LASER";
  observation->rightToLeft = sweep_rad > 0;
  observation->aperture = static_cast<float>(std::abs(sweep_rad));
  observation->maxRange = static_cast<float>(scan.range_max);
  observation->sensorPose = mrpt_pose(compose(scan.base_T_sensor, {0, 0, scan.angle_min + sweep_rad / 2}));
  observation->resizeScan(scan.ranges.size());
  for (std::size_t ray = 0; ray < scan.ranges.size(); ++ray) {
    const float range = scan.ranges[ray];
    const bool met_nothing = range > observation->maxRange;
    const bool returned = !met_nothing && range > 0 && range >= static_cast<float>(scan.range_min);
    observation->setScanRange(ray, met_nothing ? observation->maxRange : returned ? range : 0.0F);
    observation->setScanRangeValidity(ray, returned);
  }
  return observation;
}

Result<void> write(const fs::path& file, const mrpt::serialization::CSerializable& object) {
  return write_file_atomically(file, [&](std::ostream& out) {
    try {
      boost::iostreams::filtering_ostream stream;
      if (file.extension() == ".gz") stream.push(boost::iostreams::gzip_compressor());
      stream.push(out);
      std::ostream& sink = stream;
      mrpt::serialization::archiveFrom(sink) << object;
      stream.reset();
    } catch (const std::exception&) {
      out.setstate(std::ios::failbit);  // the disk is full: MRPT throws what a stream remembers
    }
  });
}

Result<void> save(const OccupancyGrid& map, const fs::path& file) {
  if (auto good = check(map); !good) return good;
  const auto grid = to_mrpt(map);
  if (!grid) return tl::unexpected(grid.error());
  return write(file, *grid);
}

Result<OccupancyGrid> load(const fs::path& file) {
  mrpt::io::CFileGZInputStream stream;
  if (!stream.open(file.string())) return fail(ErrorCode::kFailed, "cannot be opened");
  const auto object = mrpt::serialization::archiveFrom(stream).ReadObject();
  const auto* grid = dynamic_cast<const COccupancyGridMap2D*>(object.get());
  if (grid == nullptr)
    return fail(ErrorCode::kUnsupported, "holds no grid map of MRPT (COccupancyGridMap2D)");
  return from_mrpt(*grid);
}

Result<void> save(const std::vector<PlacedScan>& scans, const fs::path& file) {
  if (scans.empty()) return fail(ErrorCode::kInvalidArgument, "there are no scans to write");
  mrpt::maps::CSimpleMap map;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (auto good = validate(scans[i].scan); !good)
      return fail(good.error().code, "scan " + std::to_string(i) + ": " + good.error().message);
    auto pose = mrpt::poses::CPose3DPDFGaussian::Create();
    pose->mean = mrpt_pose(scans[i].map_T_base);
    pose->cov.setZero();
    auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(to_mrpt(scans[i].scan));
    map.insert(pose, frame);
  }
  return write(file, map);
}

/// Runs `work`; errors, thrown ones too, name the file.
template <typename Value>
void answer(const fs::path& file, Result<Value>& result, const std::function<Result<Value>()>& work) {
  try {
    result = work();
  } catch (const std::exception& e) {
    result = fail(ErrorCode::kCorrupt, sentence_of(e));
  }
  if (!result && result.error().message.find(file.string()) == std::string::npos)
    result = fail(result.error().code, file.string() + ": " + result.error().message);
}

}  // namespace

}  // namespace extperfc::sources

extern "C" void extperfc_save_gridmap(const extperfc::OccupancyGrid& map, const std::filesystem::path& file,
                                      extperfc::Result<void>& saved) {
  extperfc::sources::answer<void>(file, saved, [&] { return extperfc::sources::save(map, file); });
}

extern "C" void extperfc_load_gridmap(const std::filesystem::path& file,
                                      extperfc::Result<extperfc::OccupancyGrid>& map) {
  extperfc::sources::answer<extperfc::OccupancyGrid>(file, map,
                                                     [&] { return extperfc::sources::load(file); });
}

extern "C" void extperfc_save_simplemap(const std::vector<extperfc::sources::PlacedScan>& scans,
                                        const std::filesystem::path& file, extperfc::Result<void>& saved) {
  extperfc::sources::answer<void>(file, saved, [&] { return extperfc::sources::save(scans, file); });
}

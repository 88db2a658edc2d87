#include <algorithm>
#include <cmath>
#include <utility>

#include "extperfc/base/number_reader.hpp"
#include "extperfc/sources/scan_log.hpp"

#include "sources/carmen_line.hpp"
#include "sources/packed_file.hpp"

namespace extperfc::sources {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxLineBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxComplaints = 10;

enum class ScanKind { kFlaser, kRobotLaser };

class CarmenLog : public ScanLog {
 public:
  CarmenLog(fs::path file, PackedFile packed, const ScanLogOptions& options)
      : file_(std::move(file)), packed_(std::move(packed)), options_(options) {}

  Result<std::optional<ScanRecord>> next() override;
  [[nodiscard]] double progress() const override { return packed_.progress(); }
  [[nodiscard]] std::size_t damaged() const override { return damaged_; }
  [[nodiscard]] const std::vector<std::string>& complaints() const override { return complaints_; }

 private:
  /// No value when the line holds no scan of the selected kind.
  std::optional<ScanRecord> use_line();
  std::optional<ScanRecord> use_scan(ScanKind kind);
  void use_parameter();
  void complain(const std::string& what);

  fs::path file_;
  PackedFile packed_;
  ScanLogOptions options_;
  std::string line_;
  std::size_t number_{0};  // of the line
  std::size_t scans_{0};   // damaged ones too
  double laser_offset_m_{0};
  std::optional<ScanKind> kind_;  // some logs hold every scan as both: the first kind counts
  std::size_t damaged_{0};
  std::vector<std::string> complaints_;
};

Result<std::optional<ScanRecord>> CarmenLog::next() {
  while (true) {
    const auto read = packed_.next_line(line_, kMaxLineBytes);
    if (read == PackedFile::Line::kEnd) return std::optional<ScanRecord>();
    if (read == PackedFile::Line::kBroken)
      return fail(ErrorCode::kCorrupt, file_.string() + " is damaged or breaks off after line " +
                                           std::to_string(number_) + "; copy it again");
    ++number_;
    if (read == PackedFile::Line::kTooLong) {
      complain("longer than 1 MiB");
    } else if (auto record = use_line()) {
      return record;
    }
  }
}

std::optional<ScanRecord> CarmenLog::use_line() {
  const auto name = TokenReader(line_).token();
  if (name == "FLASER") return use_scan(ScanKind::kFlaser);
  if (name == "ROBOTLASER1") return use_scan(ScanKind::kRobotLaser);
  if (name == "PARAM") use_parameter();
  return std::nullopt;
}

std::optional<ScanRecord> CarmenLog::use_scan(ScanKind kind) {
  if (kind_.value_or(kind) != kind) return std::nullopt;
  kind_ = kind;
  auto record = kind == ScanKind::kFlaser ? parse_flaser(line_, laser_offset_m_, options_)
                                          : parse_robotlaser(line_, options_);
  if (record) {
    if (const auto valid = validate(record->scan); !valid) record = tl::unexpected(valid.error());
  }
  const std::size_t index = scans_++;
  if (record) {
    record->index = index;
    return *std::move(record);
  }
  complain(record.error().message);
  return std::nullopt;
}

void CarmenLog::use_parameter() {
  TokenReader tokens(line_);
  (void)tokens.token();
  if (tokens.token() != "robot_frontlaser_offset") return;
  if (const auto offset = tokens.number())
    laser_offset_m_ = *offset;
  else
    complain("robot_frontlaser_offset is not a number");
}

void CarmenLog::complain(const std::string& what) {
  ++damaged_;
  if (complaints_.size() < kMaxComplaints)
    complaints_.push_back(file_.filename().string() + " line " + std::to_string(number_) + ": " + what);
}

}  // namespace

Result<std::unique_ptr<ScanLog>> open_carmen_log(const fs::path& file, const ScanLogOptions& options) {
  {
    auto start = PackedFile::open(file);
    if (!start) return tl::unexpected(start.error());
    constexpr std::size_t kLook = 4096;
    const std::string text = start->read(kLook);
    if (text.find('\0') != std::string::npos)
      return fail(ErrorCode::kCorrupt, file.string() + " is not a CARMEN log: it holds no text");
  }
  auto packed = PackedFile::open(file);
  if (!packed) return tl::unexpected(packed.error());
  return std::make_unique<CarmenLog>(file, *std::move(packed), options);
}

}  // namespace extperfc::sources

#include "mapping/session.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <type_traits>
#include <utility>

#include "extperfc/base/atomic_file.hpp"

#include "mapping/map_parts.hpp"

namespace extperfc::mapping {

namespace {

constexpr char kMagic[] = "extperfc-session 1\n";
constexpr std::size_t kMagicLength = sizeof(kMagic) - 1;
static_assert(sizeof(double) == 8 && sizeof(float) == 4, "the format is written as the machine has it");

/// FNV-1a, 64 bit: finds damage, not malice.
std::uint64_t checksum(const char* data, std::size_t size) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (std::size_t i = 0; i < size; ++i)
    hash = (hash ^ static_cast<unsigned char>(data[i])) * 1099511628211ULL;
  return hash;
}

class Writer {
 public:
  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);  // NOLINT: the bytes of a number
  }
  void put(const Pose2& pose) {
    put(pose.x);
    put(pose.y);
    put(pose.yaw);
  }
  void put(const Eigen::Vector2f& point) {
    put(point.x());
    put(point.y());
  }
  void put_size(std::size_t size) { put(static_cast<std::uint64_t>(size)); }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads what Writer wrote. After the end, or an invalid value, everything reads as zero and good() is
/// false.
class Reader {
 public:
  Reader(const char* data, std::size_t size) : data_(data), left_(size) {}
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] bool at_end() const { return left_ == 0; }

  template <typename T>
  T get() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    if (left_ < sizeof value) {
      good_ = false;
      left_ = 0;
      return value;
    }
    std::memcpy(&value, data_, sizeof value);
    data_ += sizeof value;
    left_ -= sizeof value;
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(value)) {
        good_ = false;
        return 0;
      }
    }
    return value;
  }
  Pose2 pose() {
    const auto x = get<double>();
    const auto y = get<double>();
    return {x, y, get<double>()};
  }
  Eigen::Vector2f point() {
    const auto x = get<float>();
    return {x, get<float>()};
  }
  /// A count of items of `bytes_each` that are still to come.
  std::size_t size(std::size_t bytes_each) {
    const auto count = get<std::uint64_t>();
    if (count > left_ / bytes_each) {
      good_ = false;
      return 0;
    }
    return static_cast<std::size_t>(count);
  }

 private:
  const char* data_;
  std::size_t left_;
  bool good_{true};
};

void put(Writer& out, const KeyFrame& frame) {
  out.put_size(frame.scan);
  out.put(frame.travelled_m);
  out.put(frame.points.scanner);
  out.put_size(frame.points.surface.size());
  for (const SurfacePoint& point : frame.points.surface) {
    out.put(point.position);
    out.put(point.normal);
  }
  out.put_size(frame.points.clear.size());
  for (const Eigen::Vector2f& end : frame.points.clear) out.put(end);
}

KeyFrame get_frame(Reader& in) {
  KeyFrame frame;
  frame.scan = static_cast<std::size_t>(in.get<std::uint64_t>());
  frame.travelled_m = in.get<double>();
  frame.points.scanner = in.point();
  frame.points.surface.resize(in.size(4 * sizeof(float)));
  for (SurfacePoint& point : frame.points.surface) {
    point.position = in.point();
    point.normal = in.point();
  }
  frame.points.clear.resize(in.size(2 * sizeof(float)));
  for (Eigen::Vector2f& end : frame.points.clear) end = in.point();
  return frame;
}

void put(Writer& out, const Constraint& constraint) {
  out.put_size(constraint.from);
  out.put_size(constraint.to);
  out.put(constraint.from_T_to);
  for (Eigen::Index i = 0; i < 9; ++i) out.put(constraint.information(i / 3, i % 3));
  out.put(static_cast<std::uint8_t>(constraint.is_loop_closure ? 1 : 0));
  out.put(constraint.fit);
}

Constraint get_constraint(Reader& in) {
  Constraint constraint;
  constraint.from = static_cast<std::size_t>(in.get<std::uint64_t>());
  constraint.to = static_cast<std::size_t>(in.get<std::uint64_t>());
  constraint.from_T_to = in.pose();
  for (Eigen::Index i = 0; i < 9; ++i) constraint.information(i / 3, i % 3) = in.get<double>();
  constraint.is_loop_closure = in.get<std::uint8_t>() != 0;
  constraint.fit = in.get<double>();
  return constraint;
}

Session get_session(Reader& in, bool& consistent) {
  Session session;
  constexpr std::size_t kMinFrameBytes = 8 + 8 + 8 + 8 + 8 + 24;
  constexpr std::size_t kConstraintBytes = 8 + 8 + 24 + 72 + 1 + 8;
  constexpr std::size_t kScanBytes = 8 + 24 + 4;
  const std::size_t frames = in.size(kMinFrameBytes);
  for (std::size_t i = 0; i < frames && in.good(); ++i) {
    session.graph.add_node(in.pose());
    session.frames.push_back(get_frame(in));
  }
  const std::size_t constraints = in.size(kConstraintBytes);
  for (std::size_t i = 0; i < constraints && in.good(); ++i) {
    session.graph.add(get_constraint(in));
    const Constraint& constraint = session.graph.constraints().back();
    consistent = consistent && constraint.from < constraint.to && constraint.to < frames;
  }
  const std::size_t scans = in.size(kScanBytes);
  for (std::size_t i = 0; i < scans && in.good(); ++i) {
    PassedScan scan;
    scan.stamp_s = in.get<double>();
    scan.tracked = in.pose();
    scan.key_frame = in.get<std::uint32_t>();
    consistent = consistent && scan.key_frame < frames;
    session.scans.push_back(scan);
  }
  for (std::size_t i = 0; i < session.frames.size(); ++i)
    consistent = consistent && session.frames[i].scan < scans &&
                 (i == 0 || session.frames[i].scan > session.frames[i - 1].scan);
  consistent = consistent && in.good() && in.at_end() && frames > 0;
  return session;
}

tl::unexpected<Error> damaged(const std::filesystem::path& file, const std::string& what) {
  return fail(ErrorCode::kCorrupt, "mapping session " + file.string() + ": " + what);
}

}  // namespace

Session concatenated(Session first, Session second) {
  const std::size_t frames = first.frames.size();
  const std::size_t scans = first.scans.size();
  const double travelled_m = first.frames.back().travelled_m;
  const Pose2 beside = pose_beside(first.graph);
  const Pose2 moved = compose(beside, inverse(second.graph.poses().front()));
  first.graph.add(unknown_step(frames - 1, between(first.graph.poses().back(), beside)));
  for (const Pose2& pose : second.graph.poses()) first.graph.add_node(compose(moved, pose));
  for (Constraint constraint : second.graph.constraints()) {
    constraint.from += frames;
    constraint.to += frames;
    first.graph.add(constraint);
  }
  for (KeyFrame& frame : second.frames) {
    frame.scan += scans;
    frame.travelled_m += travelled_m;
    first.frames.push_back(std::move(frame));
  }
  for (PassedScan& scan : second.scans) {
    scan.key_frame += static_cast<std::uint32_t>(frames);
    first.scans.push_back(scan);
  }
  return first;
}

Result<void> write_session(const Session& session, const std::filesystem::path& file) {
  Writer out;
  out.put_size(session.frames.size());
  for (std::size_t i = 0; i < session.frames.size(); ++i) {
    out.put(session.graph.poses()[i]);
    put(out, session.frames[i]);
  }
  out.put_size(session.graph.constraints().size());
  for (const Constraint& constraint : session.graph.constraints()) put(out, constraint);
  out.put_size(session.scans.size());
  for (const PassedScan& scan : session.scans) {
    out.put(scan.stamp_s);
    out.put(scan.tracked);
    out.put(scan.key_frame);
  }
  const std::uint64_t sum = checksum(out.bytes().data(), out.bytes().size());
  out.put(sum);
  return write_file_atomically(file, [&](std::ostream& stream) {
    stream.write(kMagic, static_cast<std::streamsize>(kMagicLength));
    stream.write(out.bytes().data(), static_cast<std::streamsize>(out.bytes().size()));
  });
}

Result<Session> read_session(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return fail(ErrorCode::kNotFound, "mapping session " + file.string() + " cannot be opened");
  const std::string content{std::istreambuf_iterator<char>(stream), {}};
  if (content.compare(0, kMagicLength, kMagic) != 0)
    return damaged(
        file, "it does not begin with 'extperfc-session 1'; was it saved by another program or version?");
  constexpr std::size_t kSum = sizeof(std::uint64_t);
  if (content.size() < kMagicLength + kSum) return damaged(file, "it is cut off");
  const char* body = content.data() + kMagicLength;
  const std::size_t size = content.size() - kMagicLength - kSum;
  std::uint64_t sum = 0;
  std::memcpy(&sum, body + size, kSum);
  if (sum != checksum(body, size)) return damaged(file, "its checksum is wrong: it is cut off or damaged");
  Reader in(body, size);
  bool consistent = true;
  Session session = get_session(in, consistent);
  if (!consistent) return damaged(file, "its numbers contradict each other");
  return session;
}

}  // namespace extperfc::mapping

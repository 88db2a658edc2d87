#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"

#include "mapping/session.hpp"
#include "test/support/temporary_folder.hpp"

namespace extperfc::mapping {
namespace {

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

Pose2 random_pose(Rng& rng) {
  return {rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-3, 3)};
}

Eigen::Vector2f random_point(Rng& rng) {
  return {static_cast<float>(rng.uniform(-9, 9)), static_cast<float>(rng.uniform(-9, 9))};
}

Session random_session(std::uint64_t seed, std::size_t frames, std::size_t points) {
  Rng rng(seed);
  Session session;
  for (std::size_t i = 0; i < 2 * frames; ++i)
    session.scans.push_back({rng.uniform(0, 1e9), random_pose(rng), static_cast<std::uint32_t>(i / 2)});
  for (std::size_t i = 0; i < frames; ++i) {
    KeyFrame frame;
    frame.scan = 2 * i;
    frame.travelled_m = static_cast<double>(i) / 3;
    frame.points.scanner = random_point(rng);
    for (std::size_t k = 0; k < points; ++k)
      frame.points.surface.push_back(
          {random_point(rng), k % 3 == 0 ? Eigen::Vector2f(0, 0) : random_point(rng).normalized().eval()});
    for (std::size_t k = 0; k < i % 3; ++k) frame.points.clear.push_back(random_point(rng));
    session.frames.push_back(frame);
    session.graph.add_node(random_pose(rng));
    if (i == 0) continue;
    Constraint constraint{i - 1, i, random_pose(rng), Eigen::Matrix3d::Zero(), i % 2 == 0};
    for (int k = 0; k < 9; ++k) constraint.information(k / 3, k % 3) = rng.uniform(-10, 10);
    session.graph.add(constraint);
  }
  return session;
}

void expect_same(const Pose2& a, const Pose2& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.yaw, b.yaw);
}

void expect_same(const Session& a, const Session& b) {
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    const KeyFrame& one = a.frames[i];
    const KeyFrame& other = b.frames[i];
    expect_same(a.graph.poses()[i], b.graph.poses()[i]);
    EXPECT_EQ(one.scan, other.scan);
    EXPECT_EQ(one.travelled_m, other.travelled_m);
    EXPECT_EQ(one.points.scanner, other.points.scanner);
    EXPECT_EQ(one.points.clear, other.points.clear);
    ASSERT_EQ(one.points.surface.size(), other.points.surface.size());
    for (std::size_t k = 0; k < one.points.surface.size(); ++k) {
      EXPECT_EQ(one.points.surface[k].position, other.points.surface[k].position);
      EXPECT_EQ(one.points.surface[k].normal, other.points.surface[k].normal);
    }
  }
  ASSERT_EQ(a.graph.constraints().size(), b.graph.constraints().size());
  for (std::size_t i = 0; i < a.graph.constraints().size(); ++i) {
    const Constraint& one = a.graph.constraints()[i];
    const Constraint& other = b.graph.constraints()[i];
    EXPECT_EQ(one.from, other.from);
    EXPECT_EQ(one.to, other.to);
    EXPECT_EQ(one.information, other.information);
    EXPECT_EQ(one.is_loop_closure, other.is_loop_closure);
    expect_same(one.from_T_to, other.from_T_to);
  }
  ASSERT_EQ(a.scans.size(), b.scans.size());
  for (std::size_t i = 0; i < a.scans.size(); ++i) {
    EXPECT_EQ(a.scans[i].stamp_s, b.scans[i].stamp_s);
    EXPECT_EQ(a.scans[i].key_frame, b.scans[i].key_frame);
    expect_same(a.scans[i].tracked, b.scans[i].tracked);
  }
}

/// FNV-1a of 64 bits, as the format has it.
std::uint64_t checksum(const std::string& body) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : body) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

class SessionFile : public testing::Test {
 protected:
  /// Error of reading these bytes; empty when they were taken.
  std::string refusal(const std::string& content) const {
    // A new file each time: overwriting one makes some file systems wait for the disk.
    std::filesystem::remove(folder_.path() / "damaged");
    const auto session = read_session(folder_.write("damaged", content));
    if (session) return {};
    EXPECT_EQ(session.error().code, ErrorCode::kCorrupt);
    EXPECT_NE(session.error().message.find("damaged"), std::string::npos) << "it names the file";
    return session.error().message;
  }
  /// A file with a body of our making and the checksum that belongs to it.
  std::string refusal_of_body(const std::string& body) const {
    const std::uint64_t sum = checksum(body);
    std::string sum_bytes(sizeof sum, '\0');
    std::memcpy(sum_bytes.data(), &sum, sizeof sum);
    return refusal(kMagic + body + sum_bytes);
  }
  std::string written(const Session& session) const {
    EXPECT_TRUE(write_session(session, file_));
    return content_of(file_);
  }
  std::string body_of(const Session& session) const {
    const std::string content = written(session);
    return content.substr(kMagic.size(), content.size() - kMagic.size() - 8);
  }
  static std::string with_number(std::string body, std::size_t at, std::uint64_t value) {
    std::memcpy(body.data() + at, &value, sizeof value);
    return body;
  }

  const std::string kMagic{"extperfc-session 1\n"};
  TemporaryFolder folder_;
  std::filesystem::path file_{folder_.path() / "session"};
};

TEST_F(SessionFile, RoundTripIsBitExact) {
  for (const std::size_t frames : {1U, 7U, 60U}) {
    const Session session = random_session(frames, frames, 30);
    const std::string bytes = written(session);
    const auto read = read_session(file_);
    ASSERT_TRUE(read) << read.error().message;
    expect_same(session, *read);
    EXPECT_EQ(written(*read), bytes);
  }
}

TEST_F(SessionFile, ReplacesAnOlderOne) {
  (void)written(random_session(1, 5, 10));
  const Session newer = random_session(2, 3, 10);
  (void)written(newer);
  const auto read = read_session(file_);
  ASSERT_TRUE(read);
  expect_same(newer, *read);
}

TEST_F(SessionFile, EveryTruncationIsRefused) {
  const std::string bytes = written(random_session(3, 3, 3));
  for (std::size_t size = 0; size < bytes.size(); ++size)
    ASSERT_NE(refusal(bytes.substr(0, size)), "") << "cut off after " << size;
  EXPECT_EQ(refusal(bytes), "");
  EXPECT_NE(refusal(bytes + '\0'), "");
}

TEST_F(SessionFile, EveryFlippedByteIsRefused) {
  const std::string bytes = written(random_session(4, 2, 3));
  for (std::size_t i = 0; i < bytes.size(); ++i)
    for (const char flip : {'\x01', '\x80', '\xff'}) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      ASSERT_NE(refusal(damaged), "") << "byte " << i;
    }
}

// Unlike damage that the checksum finds: here the checksum is right, and the content is invalid.
TEST_F(SessionFile, EveryTruncationWithARightChecksumIsRefused) {
  const std::string body = body_of(random_session(5, 3, 3));
  EXPECT_EQ(refusal_of_body(body), "");
  for (std::size_t size = 0; size < body.size(); ++size)
    ASSERT_NE(refusal_of_body(body.substr(0, size)), "") << size;
  EXPECT_NE(refusal_of_body(body + std::string(8, '\0')), "");
}

TEST_F(SessionFile, FlippedBytesWithARightChecksumCrashNothing) {
  const std::string body = body_of(random_session(6, 2, 2));
  for (std::size_t i = 0; i < body.size(); ++i)
    for (const char flip : {'\x01', '\x40', '\x7f', '\xff'}) {
      std::string damaged = body;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      (void)refusal_of_body(damaged);  // taken or refused: other numbers may be as good
    }
}

TEST_F(SessionFile, HostileSizesAreRefused) {
  const Session session = random_session(7, 2, 2);
  const std::string body = body_of(session);
  // Number of frames; of the first frame's points (behind its pose, scan, way and scanner).
  constexpr std::size_t kPointCount = 8 + 24 + 8 + 8 + 8;
  for (const std::size_t at : {std::size_t{0}, kPointCount})
    for (const std::uint64_t size : {std::uint64_t{1} << 20U, std::uint64_t{1} << 40U,
                                     std::uint64_t{1} << 60U, std::numeric_limits<std::uint64_t>::max()})
      EXPECT_NE(refusal_of_body(with_number(body, at, size)), "") << at << " " << size;
  EXPECT_NE(refusal_of_body(std::string(24, '\0')), "") << "no key frames";
  EXPECT_NE(refusal_of_body(""), "");
}

TEST_F(SessionFile, ContradictionsAreRefused) {
  const auto refused = [&](auto change) {
    Session session = random_session(8, 4, 2);
    change(session);
    return refusal(written(session)) != "";
  };
  EXPECT_FALSE(refused([](Session&) {}));
  EXPECT_TRUE(refused([](Session& s) { s.graph.constraints()[1].from = 4; }));
  EXPECT_TRUE(refused([](Session& s) { s.graph.constraints()[1].to = std::size_t{1} << 60U; }));
  EXPECT_TRUE(refused([](Session& s) { s.scans[3].key_frame = 4; }));
  EXPECT_TRUE(refused([](Session& s) { s.frames[2].scan = 8; }));
  EXPECT_TRUE(refused([](Session& s) { s.scans.clear(); }));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused([](Session& s) { s.scans[0].tracked.x = kNan; }));
  EXPECT_TRUE(refused([](Session& s) { s.graph.constraints()[0].information(2, 1) = kNan; }));
  EXPECT_TRUE(
      refused([](Session& s) { s.frames[0].points.surface[0].normal.x() = static_cast<float>(kNan); }));
}

// Reading these would not fail, but going on from them does: the path is read in the order of key frames.
TEST_F(SessionFile, KeyFramesOutOfOrderAreRefused) {
  Session session = random_session(9, 4, 2);
  std::swap(session.frames[1].scan, session.frames[2].scan);
  EXPECT_NE(refusal(written(session)), "");
  session = random_session(9, 4, 2);
  session.graph.constraints()[0].from = session.graph.constraints()[0].to;
  EXPECT_NE(refusal(written(session)), "") << "a key frame is not seen from itself";
  session = random_session(9, 4, 2);
  std::swap(session.graph.constraints()[1].from, session.graph.constraints()[1].to);
  EXPECT_NE(refusal(written(session)), "") << "nor from a later one";
}

TEST_F(SessionFile, ErrorsSayWhatIsWrong) {
  const auto missing = read_session(folder_.path() / "nowhere");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(missing.error().message.find("nowhere"), std::string::npos);
  EXPECT_NE(refusal("extperfc-session 2\nand so on").find("version"), std::string::npos);
  EXPECT_NE(refusal("").find("version"), std::string::npos);
  EXPECT_FALSE(write_session(random_session(1, 1, 1), folder_.path() / "no" / "folder" / "here"));
}

}  // namespace
}  // namespace extperfc::mapping

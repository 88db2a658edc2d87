#include "detect/area_resize.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <opencv2/core/hal/intrin.hpp>

// One copy of a function per instruction set, chosen when the library is loaded. Sanitizers instrument that
// choice before they are ready for it.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define EXTPERFC_AVX2_CLONE __attribute__((target_clones("avx2", "default")))
#else
#define EXTPERFC_AVX2_CLONE
#endif

namespace extperfc::detect {

namespace {

using Float4 = cv::v_float32x4;

constexpr int kBlock = 4;       // pixels of the result that are computed together along a row
constexpr int kRowGroup = 3;    // rows of the image that are added in one go
constexpr int kUnit = 1 << 16;  // weights are multiples of 1 / kUnit: times a byte, floats sum them exactly

struct RowGroup {
  std::array<const std::uint8_t*, kRowGroup> rows;
  std::array<float, kRowGroup> weights;
};

EXTPERFC_AVX2_CLONE void set_to_rows(const RowGroup& group, std::size_t count, float* __restrict sum) {
  const auto [a, b, c] = group.rows;
  const auto [wa, wb, wc] = group.weights;
  for (std::size_t i = 0; i < count; ++i)
    sum[i] = static_cast<float>(a[i]) * wa + static_cast<float>(b[i]) * wb + static_cast<float>(c[i]) * wc;
}

EXTPERFC_AVX2_CLONE void add_rows(const RowGroup& group, std::size_t count, float* __restrict sum) {
  const auto [a, b, c] = group.rows;
  const auto [wa, wb, wc] = group.weights;
  for (std::size_t i = 0; i < count; ++i)
    sum[i] += static_cast<float>(a[i]) * wa + static_cast<float>(b[i]) * wb + static_cast<float>(c[i]) * wc;
}

/// A block of pixels, one element per channel.
using Block = std::array<Float4, 4>;

Block grey_block(const float* row, const int* starts, const float* weights, int taps) {
  Float4 sum = cv::v_setzero_f32();
  for (int t = 0; t < taps; ++t, ++row, weights += kBlock)
    sum = cv::v_muladd(Float4(row[starts[0]], row[starts[1]], row[starts[2]], row[starts[3]]),
                       cv::v_load(weights), sum);
  return {sum, sum, sum, sum};
}

/// With three channels the fourth element is rubbish.
Block colour_block(const float* row, const int* starts, const float* weights, int taps, int channels) {
  Float4 p0 = cv::v_setzero_f32();
  Float4 p1 = p0;
  Float4 p2 = p0;
  Float4 p3 = p0;
  for (int t = 0; t < taps; ++t, row += channels, weights += kBlock) {
    p0 = cv::v_muladd(cv::v_load(row + starts[0]), cv::v_setall_f32(weights[0]), p0);
    p1 = cv::v_muladd(cv::v_load(row + starts[1]), cv::v_setall_f32(weights[1]), p1);
    p2 = cv::v_muladd(cv::v_load(row + starts[2]), cv::v_setall_f32(weights[2]), p2);
    p3 = cv::v_muladd(cv::v_load(row + starts[3]), cv::v_setall_f32(weights[3]), p3);
  }
  Block block;
  cv::v_transpose4x4(p0, p1, p2, p3, block[0], block[1], block[2], block[3]);
  return block;
}

void store(float* target, const Float4& values, int count) {
  if (count >= kBlock) return cv::v_store(target, values);
  std::array<float, kBlock> all{};
  cv::v_store(all.data(), values);
  std::copy_n(all.begin(), count, target);
}

}  // namespace

bool AreaResizer::suits(const cv::Mat& image, cv::Size result) {
  // From 640 x 480 to 320 x 240, cv::resize and the conversion take 83 us, this 197.
  const bool halved = image.cols == 2 * result.width && image.rows == 2 * result.height;
  return image.depth() == CV_8U && image.channels() != 2 && image.channels() <= 4 &&
         image.cols >= result.width && image.rows >= result.height && image.size() != result && !halved;
}

/// In whole numbers: a pixel of the image is `to` long, one of the result `from`. Rounding the sums of
/// weights, not the weights, makes them add up to one.
AreaResizer::Axis AreaResizer::make_axis(int from, int to) {
  Axis axis{from, to, 0, {}, {}};
  const auto first = [&](std::int64_t i) { return i * from / to; };
  const auto end = [&](std::int64_t i) { return ((i + 1) * from + to - 1) / to; };
  for (int i = 0; i < to; ++i) {
    axis.starts.push_back(static_cast<int>(first(i)));
    axis.taps = std::max(axis.taps, static_cast<int>(end(i) - first(i)));
  }
  for (int i = 0; i < to; ++i) {
    std::int64_t before = 0;
    for (int t = 0; t < axis.taps; ++t) {
      const std::int64_t covered = (first(i) + t + 1) * to - static_cast<std::int64_t>(i) * from;
      const std::int64_t sum = std::min<std::int64_t>(covered, from) * kUnit / from;
      axis.weights.push_back(static_cast<float>(sum - before) / static_cast<float>(kUnit));
      before = sum;
    }
  }
  return axis;
}

void AreaResizer::prepare(const cv::Mat& image, cv::Size result) {
  if (rows_.from != image.rows || rows_.to != result.height) rows_ = make_axis(image.rows, result.height);
  if (columns_.from == image.cols && columns_.to == result.width && channels_ == image.channels()) return;
  columns_ = make_axis(image.cols, result.width);
  channels_ = image.channels();
  const auto taps = static_cast<std::size_t>(columns_.taps);
  const auto channels = static_cast<std::size_t>(channels_);
  const auto width = static_cast<std::size_t>(result.width);
  const std::size_t filled = (width + kBlock - 1) / kBlock * kBlock;
  block_starts_.assign(filled, 0);
  block_weights_.assign(filled * taps, 0.0F);
  for (std::size_t x = 0; x < width; ++x) {
    block_starts_[x] = columns_.starts[x] * channels_;
    for (std::size_t t = 0; t < taps; ++t)
      block_weights_[(x / kBlock * taps + t) * kBlock + x % kBlock] = columns_.weights[x * taps + t];
  }
  // Surplus weights and the unused fourth channel reach beyond the last pixel: zeros stand there.
  row_.assign((static_cast<std::size_t>(image.cols) + taps) * channels + kBlock, 0.0F);
}

void AreaResizer::sum_rows(const cv::Mat& image, int y) {
  const float* weights = rows_.weights.data() + static_cast<std::ptrdiff_t>(y) * rows_.taps;
  const int start = rows_.starts[static_cast<std::size_t>(y)];
  const std::size_t count = static_cast<std::size_t>(image.cols) * image.elemSize();
  for (int first = 0; first < rows_.taps; first += kRowGroup) {
    RowGroup group{};
    for (int k = 0; k < kRowGroup; ++k) {
      const int t = first + k;
      group.rows[static_cast<std::size_t>(k)] = image.ptr(std::min(start + t, image.rows - 1));
      group.weights[static_cast<std::size_t>(k)] = t < rows_.taps ? weights[t] : 0.0F;
    }
    (first == 0 ? set_to_rows : add_rows)(group, count, row_.data());
  }
}

void AreaResizer::write_row(int y, std::array<AreaPlane, 3>& planes) const {
  std::array<float*, 3> targets{};
  std::array<Float4, 3> scales;
  std::array<Float4, 3> offsets;
  for (std::size_t c = 0; c < 3; ++c) {
    targets[c] = planes[c].pixels.ptr<float>(y);
    scales[c] = cv::v_setall_f32(static_cast<float>(planes[c].scale));
    offsets[c] = cv::v_setall_f32(static_cast<float>(planes[c].offset));
  }
  const int taps = columns_.taps;
  for (int x = 0; x < columns_.to; x += kBlock) {
    const int* starts = block_starts_.data() + x;
    const float* weights = block_weights_.data() + static_cast<std::ptrdiff_t>(x) * taps;
    const Block block = channels_ == 1 ? grey_block(row_.data(), starts, weights, taps)
                                       : colour_block(row_.data(), starts, weights, taps, channels_);
    for (std::size_t c = 0; c < 3; ++c) {
      const Float4 levels = cv::v_cvt_f32(cv::v_round(block[static_cast<std::size_t>(planes[c].channel)]));
      store(targets[c] + x, cv::v_muladd(levels, scales[c], offsets[c]), columns_.to - x);
    }
  }
}

void AreaResizer::run(const cv::Mat& image, std::array<AreaPlane, 3>& planes) {
  const cv::Size result = planes[0].pixels.size();
  prepare(image, result);
  for (int y = 0; y < result.height; ++y) {
    sum_rows(image, y);
    write_row(y, planes);
  }
}

}  // namespace extperfc::detect

#include "localize/field_model.hpp"

#include <algorithm>
#include <cmath>

namespace extperfc::localize {

FieldModel::FieldModel(double z_hit, double z_rand, double sigma_m, const DistanceField& field) {
  for (std::size_t byte = 0; byte < log_likelihood_.size(); ++byte) {
    const double d = field.metres(static_cast<std::uint8_t>(byte)) / sigma_m;
    const double hit = byte == 255 ? 0 : std::exp(-d * d / 2);  // 255: nothing near enough to count
    log_likelihood_[byte] = static_cast<float>(std::log((z_hit * hit + z_rand) / (z_hit + z_rand)));
  }
}

void FieldModel::mean_logs(const DistanceField& field, const Beams& beams, const ParticleSet& particles,
                           std::vector<float>& result, std::size_t every) const {
  constexpr std::size_t kBlock = 64;  // two loops over a block: the first one has no look-ups and vectorises
  const float scale = field.cells_per_m();
  std::vector<float> bx;
  std::vector<float> by;
  for (std::size_t i = 0; i < beams.ends(); i += every) {
    bx.push_back(beams.x_m[i] * scale);
    by.push_back(beams.y_m[i] * scale);
  }
  const std::size_t count = bx.size();
  const float right = field.last_column();
  const float top = field.last_row();
  const int stride = field.stride();
  const std::uint8_t* const bytes = field.bytes();
  std::array<int, kBlock> cell{};
  result.assign(particles.size(), 0.0F);
  if (count == 0) return;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const float c = std::cos(particles.yaw[p]);
    const float s = std::sin(particles.yaw[p]);
    const float x = particles.x[p] * scale + field.margin();
    const float y = particles.y[p] * scale + field.margin();
    float even = 0;
    float odd = 0;
    for (std::size_t start = 0; start < count; start += kBlock) {
      const std::size_t length = std::min(kBlock, count - start);
      for (std::size_t i = 0; i < length; ++i) {
        float column = x + c * bx[start + i] - s * by[start + i];
        float row = y + s * bx[start + i] + c * by[start + i];
        column = column > 0 ? column : 0;
        row = row > 0 ? row : 0;
        column = column < right ? column : right;
        row = row < top ? row : top;
        cell[i] = static_cast<int>(row) * stride + static_cast<int>(column);
      }
      std::size_t i = 0;
      for (; i + 1 < length; i += 2) {
        even += log_likelihood_[bytes[cell[i]]];
        odd += log_likelihood_[bytes[cell[i + 1]]];
      }
      if (i < length) even += log_likelihood_[bytes[cell[i]]];
    }
    result[p] = (even + odd) / static_cast<float>(count);
  }
}

}  // namespace extperfc::localize
